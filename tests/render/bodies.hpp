#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::render {

/// Body turned about z from a closed (radius, height) outline, counter-clockwise; outward faces.
inline solvers::mesh::SurfaceMesh turned_object(const std::vector<std::array<double, 2>>& outline,
                                                int segments) {
  solvers::mesh::SurfaceMesh mesh;
  const int n = static_cast<int>(outline.size());
  for (int i = 0; i < segments; ++i) {
    const double angle = 2 * std::numbers::pi * i / segments;
    for (const auto& [radius, height] : outline) {
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
    }
  }
  for (int i = 0; i < segments; ++i) {
    const int j = (i + 1) % segments;
    for (int a = 0; a < n; ++a) {
      const int b = (a + 1) % n;
      const bool on_axis_a = outline[std::size_t(a)][0] == 0;
      const bool on_axis_b = outline[std::size_t(b)][0] == 0;
      // All points on the axis are the first one, or the body would be open there.
      const auto at = [&](int segment, int point) {
        return (outline[std::size_t(point)][0] == 0 ? 0 : segment) * n + point;
      };
      if (!on_axis_a) mesh.triangles.push_back({at(i, a), at(j, a), at(i, b)});
      if (!on_axis_b) mesh.triangles.push_back({at(j, a), at(j, b), at(i, b)});
    }
  }
  return mesh;
}

inline solvers::mesh::SurfaceMesh sphere(double radius, int segments = 64) {
  std::vector<std::array<double, 2>> outline;
  const int rings = segments / 2;
  for (int i = 0; i <= rings; ++i) {
    const double angle = std::numbers::pi * (double(i) / rings - 0.5);
    const bool pole = i == 0 || i == rings;
    outline.push_back({pole ? 0 : radius * std::cos(angle), radius * std::sin(angle)});
  }
  return turned_object(outline, segments);
}

/// Half a hollow sphere, open upwards.
inline solvers::mesh::SurfaceMesh bowl(double radius, double wall, int segments = 64) {
  std::vector<std::array<double, 2>> outline;
  const int rings = segments / 4;
  const auto add = [&](double r, int i) {
    const double angle = std::numbers::pi / 2 * (double(i) / rings - 1);
    outline.push_back({i == 0 ? 0 : r * std::cos(angle), r * std::sin(angle)});
  };
  for (int i = 0; i <= rings; ++i) add(radius, i);
  for (int i = rings; i >= 0; --i) add(radius - wall, i);
  return turned_object(outline, segments);
}

inline solvers::mesh::SurfaceMesh box(const Vec3& low, const Vec3& high) {
  solvers::mesh::SurfaceMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                               i & 4 ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

inline void append(solvers::mesh::SurfaceMesh& mesh, const solvers::mesh::SurfaceMesh& more,
                   bool flip) {
  const auto shift = static_cast<std::int32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (solvers::mesh::Triangle triangle : more.triangles) {
    for (std::int32_t& vertex : triangle) vertex += shift;
    if (flip) std::swap(triangle[1], triangle[2]);
    mesh.triangles.push_back(triangle);
  }
}

inline void transform(solvers::mesh::SurfaceMesh& mesh, const Eigen::Matrix3d& turn,
                      const Vec3& shift) {
  for (Vec3& vertex : mesh.vertices) vertex = turn * vertex + shift;
}

}  // namespace carillon::render
