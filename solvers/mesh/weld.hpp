#pragma once

#include <cstdint>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh {

/// For every point the first one at exactly the same place (-0 equals 0).
std::vector<std::int32_t> first_at_place(const std::vector<Vec3>& points);

/// Replaces every vertex by its representative, which represents itself, and drops those that are
/// replaced.
/// @return vertices that were dropped
std::int64_t merge_vertices(SurfaceMesh& mesh, const std::vector<std::int32_t>& representative);

/// Merges vertices at exactly the same place.
/// @return vertices that were dropped
std::int64_t weld(SurfaceMesh& mesh);

/// Drops vertices that no triangle uses.
/// @return how many
std::int64_t drop_unreferenced(SurfaceMesh& mesh);

}  // namespace carillon::solvers::mesh
