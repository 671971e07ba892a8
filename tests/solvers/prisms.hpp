#pragma once

#include <vector>

#include "solvers/mesh/readers/detail/polygon_mesh.hpp"

namespace carillon::test {

/// A body between a plane outline, counter-clockwise, and its copy at a height [m], in as few
/// triangles as CAD exports it.
inline solvers::mesh::SurfaceMesh prism(const std::vector<Vec2>& outline, double height) {
  solvers::mesh::readers::PolygonMesh body;
  const auto n = static_cast<std::int32_t>(outline.size());
  for (const double z : {0.0, height})
    for (const Vec2& p : outline) body.vertices.emplace_back(p.x(), p.y(), z);
  for (std::int32_t i = 0; i < n; ++i) body.corners.push_back(n - 1 - i);
  body.end_polygon();
  for (std::int32_t i = 0; i < n; ++i) body.corners.push_back(n + i);
  body.end_polygon();
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t next = (i + 1) % n;
    body.corners.insert(body.corners.end(), {i, next, n + next, n + i});
    body.end_polygon();
  }
  return solvers::mesh::readers::triangulate(std::move(body));
}

}  // namespace carillon::test
