#pragma once

#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::render {

/// Unit normal at every vertex, the mean over its faces weighted by their angle there (Thuermer and
/// Wuethrich 1998); vertices at the same place count as one. Zero where there is none.
std::vector<Vec3> vertex_normals(const std::vector<Vec3>& vertices,
                                 const std::vector<solvers::mesh::Triangle>& triangles);

}  // namespace carillon::render
