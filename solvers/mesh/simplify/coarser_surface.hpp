#pragma once

#include <cstddef>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::simplify {

/// A closed surface with fewer vertices, which are some of its own, so that values at them stay
/// valid. Edges are collapsed into one of their ends, first those that leave the shortest edges, so
/// that vertices stay evenly spread; edges between faces that meet at more than `crease` stay where
/// they are, and so do their corners (CGAL's edge collapse).
///
/// @param mesh      other vertices than those of its triangles may be there
/// @param vertices  to stop at; more are left where no edge can be collapsed any more
/// @param crease    [rad]
/// @return triangles over mesh.vertices
/// @throws InputError  the surface is open or not manifold
SurfaceMesh coarser_surface(const SurfaceMesh& mesh, std::size_t vertices, double crease);

}  // namespace carillon::solvers::mesh::simplify
