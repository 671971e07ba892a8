#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "render/scene_frame.hpp"
#include "tests/render/bodies.hpp"

namespace carillon::render {

/// A camera's rays and pixels by the formulas of a pinhole.
struct Pinhole {
  SceneCamera camera;
  Vec3 forward, right, up;
  double focal = 0;  ///< [pixel]

  explicit Pinhole(const SceneCamera& of) : camera(of) {
    forward = (camera.target - camera.eye).normalized();
    right = forward.cross(camera.up).normalized();
    up = right.cross(forward);
    focal = camera.height / 2.0 / std::tan(camera.field_of_view / 2);
  }
  /// Through the middle of a pixel; one metre along it is one metre of depth.
  Vec3 ray(int column, int row) const {
    return forward + (column + 0.5 - camera.width / 2.0) / focal * right -
           (row + 0.5 - camera.height / 2.0) / focal * up;
  }
  Vec3 place(int column, int row, double depth) const {
    return camera.eye + depth * ray(column, row);
  }
  Eigen::Vector2d pixel(const Vec3& place) const {
    const Vec3 off = place - camera.eye;
    return {camera.width / 2.0 + focal * off.dot(right) / off.dot(forward),
            camera.height / 2.0 - focal * off.dot(up) / off.dot(forward)};
  }
};

inline std::size_t at(const SceneFrame& frame, int column, int row) {
  return std::size_t(row) * std::size_t(frame.color.width) + std::size_t(column);
}

inline int brightness(const SceneFrame& frame, int column, int row) {
  const auto* p = frame.color.pixels.data() + 3 * at(frame, column, row);
  return p[0] + p[1] + p[2];
}

inline SceneFrame draw(const Scene& scene, const std::vector<ScenePose>& poses) {
  return SceneRenderer(scene).draw(poses);
}

/// A rectangle in the plane z = 0 from the origin, facing up.
inline solvers::mesh::SurfaceMesh sheet(double width, double height) {
  solvers::mesh::SurfaceMesh mesh;
  for (int i = 0; i < 4; ++i) mesh.vertices.emplace_back(i % 2 * width, i < 2 ? 0 : height, 0);
  mesh.triangles = {{0, 1, 3}, {0, 3, 2}};
  return mesh;
}

/// A slab below z = 0 with a map on its upper side, all over it.
inline SceneBody slab(const maps::SurfaceMap& map, double thickness) {
  SceneBody body;
  body.mesh = box({0, 0, -thickness}, {map.size().x(), map.size().y(), 0});
  body.texture = maps::TexturedFace{std::make_shared<const maps::SurfaceMap>(map), Vec3::Zero(),
                                    Vec3::UnitX(), Vec3::UnitY(), map.size()};
  return body;
}

/// Depth at which a ray first meets the relief of a slab at the origin, by small steps along it;
/// no number where it meets a side first, infinite where it meets nothing.
inline double first_hit(const maps::SurfaceMap& map, const Vec3& eye, const Vec3& ray) {
  const double lowest = *std::min_element(map.heights.begin(), map.heights.end());
  double depth = eye.z() > 0 ? -eye.z() / ray.z() : 0;
  if (depth < 0) return INFINITY;
  const auto outside = [&](const Vec3& p) {
    return p.x() < 0 || p.y() < 0 || p.x() > map.size().x() || p.y() > map.size().y();
  };
  if (outside(eye + depth * ray)) return NAN;
  const double step = map.texel / 60 / ray.norm();
  for (;; depth += step) {
    const Vec3 p = eye + depth * ray;
    if (p.z() < lowest - map.texel || p.z() > 1e-12) return INFINITY;
    if (outside(p)) return INFINITY;
    if (maps::height_at(map, p.head<2>()) >= p.z()) return depth;
  }
}

}  // namespace carillon::render
