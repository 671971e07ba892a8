#pragma once

#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Remeshes a clean closed surface to sizes that follow local thickness and curvature, feature
/// lines and corners kept, and fills it by boundary-constrained Delaunay (Gmsh's library): a thin
/// wall gets one layer of wide elements. Elements are curved on to the surface (curve_mesh) and
/// keep its volume (keep_volume). Several components and cavities (components that look inward) are
/// allowed. What does not keep the surface is tried again with smaller elements.
/// @return mesh and quality, with its fit to the surface; no diagnosis
/// @throws SolverError  Gmsh failed, more than options.max_elements are needed (names the
///                      element_size that would fit), or no try kept the surface's volume
MeshResult tetrahedralise(const SurfaceMesh& surface, const MeshOptions& options);

}  // namespace carillon::solvers::mesh::tetrahedra
