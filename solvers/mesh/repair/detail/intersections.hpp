#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::repair {

/// Triangles whose corners lie on one line (exact predicate), or that name a vertex twice.
std::vector<std::size_t> degenerate_triangles(const SurfaceMesh& mesh);

/// Pairs of triangles that meet in more than the vertex or edge they share (exact predicates,
/// CGAL); at most `limit` of them, sorted. Degenerate triangles and twins are left out. Works on
/// any soup.
std::vector<std::pair<std::size_t, std::size_t>> intersecting_pairs(const SurfaceMesh& mesh,
                                                                    std::size_t limit);

}  // namespace carillon::solvers::mesh::repair
