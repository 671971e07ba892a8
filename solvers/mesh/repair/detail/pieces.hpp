#pragma once

#include <optional>

#include "solvers/mesh/shape_source.hpp"
#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::repair {

/// Removes what is no part of the body: closed pieces of less than a millionth of the volume, and
/// open ones of less than a hundredth of the area where there are closed ones.
/// @return pieces removed
std::int64_t drop_debris(SurfaceMesh& mesh);

/// Volume of the material that closed pieces bound: those inside an odd number of others count as
/// cavities.
double nested_volume(const SurfaceMesh& mesh);

/// Settles how closed pieces belong together. Those that meet are united; one that looks inward and
/// lies in the others for the most part is taken out of them. Outer pieces look outward; an inner
/// one that looks the other way than the piece around it is a cavity, one that looks the same way
/// is swallowed (its material is there already).
///
/// @param trusted  the input's orientations mean something; otherwise inner pieces are cavities
/// @param report   actions and swallowed volume are added to
/// @return nothing when pieces that meet cannot be united
std::optional<SurfaceMesh> resolve_pieces(const SurfaceMesh& mesh, bool trusted,
                                          RepairReport& report);

/// Whether closed pieces that meet are held together by faces or volume that they share: edges and
/// points alone hold nothing. Of many pieces some may touch the rest alone.
bool held_together(const SurfaceMesh& mesh);

}  // namespace carillon::solvers::mesh::repair
