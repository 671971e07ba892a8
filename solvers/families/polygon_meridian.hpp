#pragma once

#include "solvers/families/outline.hpp"
#include "solvers/mesh/meridian.hpp"

namespace carillon::solvers::families {

/// Section of a checked profile: its constrained Delaunay triangulation (CGAL, refined until no
/// angle is below 6 degrees: cells of high order may be long and thin), each triangle cut into
/// three quadrilaterals at its centroid and the middles of its sides. Blocks are graded towards
/// re-entrant corners.
mesh::Meridian polygon_meridian(const ProfilePolygon& profile);

}  // namespace carillon::solvers::families
