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
  double area = 0;               ///< of what was filled, holes of three sides apart [m^2]
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

/// What is left of a body without another (CGAL corefinement); both as unite() takes them.
/// @return nothing when the rest is not a manifold
std::optional<SurfaceMesh> subtract(const SurfaceMesh& body, const SurfaceMesh& hollow);

/// Whether two bodies, as unite() takes them, share edges or points and neither volume nor faces.
bool only_touch(const SurfaceMesh& one, const SurfaceMesh& other);

/// Alpha wrap: the surface a ball of diameter `alpha` leaves free, `offset` away from the
/// triangles (Portaneri et al. 2022, CGAL).
SurfaceMesh alpha_wrap(const SurfaceMesh& soup, double alpha, double offset);

/// Moves the vertices of a wrap back onto the triangles they wrap, as far as that leaves the
/// surface free of self-intersections; so walls keep their thickness.
SurfaceMesh shrink_onto(const SurfaceMesh& wrap, const SurfaceMesh& soup);

/// How far a body is from what triangles bound: points beside them that lie in it but outside of
/// the triangles (a slot that was closed), or the other way (a wall that was lost).
struct Misplaced {
  double share = 0;   ///< of the points
  double facing = 0;  ///< of the surface: where it lies between two faces that look at each other
  double width = 0;   ///< of those gaps and walls, the median [m]
};

/// The triangles may be open; their winding number tells inside from outside (Jacobson et al.
/// 2013).
/// @param extent  largest distance of the points from their triangles [m]; half of a gap or a wall
///                where that is less
/// @param alpha   of the wrap: wider gaps are open in it [m]
Misplaced misplaced_points(const SurfaceMesh& soup, const SurfaceMesh& body, double extent,
                           double alpha);

/// Share of a surface's area from which another one lies within `reach` [m] straight ahead or
/// behind.
double facing_share(const SurfaceMesh& one, const SurfaceMesh& other, double reach);

/// Two offset sheets, half of `thickness` to either side of an oriented manifold sheet, and walls
/// along its border.
SurfaceMesh thicken(const SurfaceMesh& sheet, double thickness);

}  // namespace carillon::solvers::mesh::repair
