#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::readers {

/// Polygons as a file lists them, before they are cut into triangles.
struct PolygonMesh {
  std::vector<Vec3> vertices;
  std::vector<std::int32_t> corners;  ///< of all polygons, one after the other
  std::vector<std::size_t> ends;      ///< where each polygon's corners end
  void end_polygon() { ends.push_back(corners.size()); }
};

/// Triangles of one polygon, which may be concave or slightly bent: a fan when it is convex, else
/// ears cut off in the projection on its best plane (Newell's normal). n - 2 triangles, always;
/// the polygon's sense of rotation is kept.
void triangulate_polygon(const std::vector<Vec3>& vertices, std::span<const std::int32_t> polygon,
                         std::vector<Triangle>& triangles);

/// All polygons; those with fewer than three corners (points, lines) are left out.
SurfaceMesh triangulate(PolygonMesh polygons);

}  // namespace carillon::solvers::mesh::readers
