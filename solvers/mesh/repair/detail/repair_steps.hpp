#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::repair {

/// What to close: how wide a gap may be before it is an opening rather than a defect.
struct HoleLimits {
  double diagonal = 0;     ///< of the surface's box [m]
  double area = 0;         ///< of the surface [m^2]
  bool gaps_only = false;  ///< the surface is a sheet on purpose: only what a few triangles left
};

struct HoleCount {
  std::int64_t filled = 0;
  std::int64_t left = 0;
  double largest_perimeter = 0;  ///< of those left [m]
};

/// Fills holes by the triangulation of least area and bend (CGAL). Holes of three sides always;
/// wider ones when they are small beside the surface. The orientation must be consistent.
HoleCount fill_holes(SurfaceMesh& mesh, const HoleLimits& limits);

/// What make_manifold() changed.
struct ManifoldChanges {
  bool cut = false;             ///< non-manifold edges or vertices were cut apart
  std::int64_t degenerate = 0;  ///< triangles without area that were removed
};

/// Cuts the surface apart where more than two triangles or more than one fan meet, stitches what
/// then fits together, removes triangles without area by flips and collapses (CGAL). The majority
/// of each component keeps its orientation.
/// @return nothing when CGAL cannot make it a manifold
std::optional<SurfaceMesh> make_manifold(const SurfaceMesh& mesh, ManifoldChanges& changes);

/// Removes small self-intersections by smoothing and by filling anew (CGAL).
/// @return nothing when some are left
std::optional<SurfaceMesh> remove_self_intersections(const SurfaceMesh& mesh);

/// Boolean union of closed outward surfaces, each free of self-intersections (CGAL corefinement).
/// @return nothing when the union is not a manifold
std::optional<SurfaceMesh> unite(const std::vector<SurfaceMesh>& bodies);

/// Alpha wrap: the surface a ball of diameter `alpha` leaves free, `offset` away from the
/// triangles (Portaneri et al. 2022, CGAL).
SurfaceMesh alpha_wrap(const SurfaceMesh& soup, double alpha, double offset);

/// Moves the vertices of a wrap back onto the triangles they wrap, as far as that leaves the
/// surface free of self-intersections; so walls keep their thickness.
SurfaceMesh shrink_onto(const SurfaceMesh& wrap, const SurfaceMesh& soup);

/// Two offset sheets, half of `thickness` to either side of an oriented manifold sheet, and walls
/// along its border.
SurfaceMesh thicken(const SurfaceMesh& sheet, double thickness);

}  // namespace carillon::solvers::mesh::repair
