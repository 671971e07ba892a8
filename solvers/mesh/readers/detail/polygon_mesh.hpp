#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::solvers::mesh::readers {

/// Polygons as a file lists them, before they are cut into triangles.
struct PolygonMesh {
  std::vector<Vec3> vertices;
  std::vector<std::int32_t> corners;  ///< of all polygons, one after the other
  std::vector<std::size_t> ends;      ///< where each polygon's corners end
  /// Where vertices stand that are not finite, for those that a polygon uses.
  std::map<std::int32_t, std::string> not_finite;

  void add_vertex(const Vec3& point, const auto& source) {
    if (!point.allFinite()) not_finite[static_cast<std::int32_t>(vertices.size())] = source.where();
    vertices.push_back(point);
  }
  void end_polygon() { ends.push_back(corners.size()); }
};

/// Triangles of one polygon, which may be concave or slightly bent: a fan when it is convex, else
/// ears cut off in the projection on its best plane (Newell's normal). n - 2 triangles, always;
/// the polygon's sense of rotation is kept.
void triangulate_polygon(const std::vector<Vec3>& vertices, std::span<const std::int32_t> polygon,
                         std::vector<Triangle>& triangles);

/// All polygons; those with fewer than three corners (points, lines) and vertices of none are left
/// out.
/// @throws InputError  a vertex of one is not finite
SurfaceMesh triangulate(PolygonMesh polygons);

}  // namespace carillon::solvers::mesh::readers
