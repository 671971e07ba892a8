#pragma once

#include <cstdint>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::render {

/// For every vertex the first one at exactly the same place.
std::vector<std::int32_t> first_at_same_place(const std::vector<Vec3>& vertices);

/// Unit normal at every vertex, the mean over its faces weighted by their angle there (Thuermer and
/// Wuethrich 1998); vertices at the same place count as one. Zero where there is none.
std::vector<Vec3> vertex_normals(const std::vector<Vec3>& vertices,
                                 const std::vector<solvers::mesh::Triangle>& triangles);

/// Angle between two edges that leave a corner [rad].
double corner_angle(const Vec3& one, const Vec3& two);

}  // namespace carillon::render
