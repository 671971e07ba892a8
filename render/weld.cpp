#include "render/weld.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace carillon::render {

std::vector<std::int32_t> first_at_same_place(const std::vector<Vec3>& vertices) {
  std::vector<std::int32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto place = [&](std::int32_t i) {
    const Vec3& v = vertices[static_cast<std::size_t>(i)];
    return std::array<double, 3>{v.x(), v.y(), v.z()};
  };
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    const auto pa = place(a), pb = place(b);
    return pa < pb || (pa == pb && a < b);
  });
  std::vector<std::int32_t> first(vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && place(order[i]) == place(order[i - 1]);
    first[static_cast<std::size_t>(order[i])] =
        same ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  return first;
}

double corner_angle(const Vec3& one, const Vec3& two) {
  return std::atan2(one.cross(two).norm(), one.dot(two));
}

std::vector<Vec3> vertex_normals(const std::vector<Vec3>& vertices,
                                 const std::vector<solvers::mesh::Triangle>& triangles) {
  const std::vector<std::int32_t> first = first_at_same_place(vertices);
  std::vector<Vec3> normals(vertices.size(), Vec3(Vec3::Zero()));
  for (const solvers::mesh::Triangle& triangle : triangles) {
    std::array<Vec3, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) corner[k] = vertices[static_cast<std::size_t>(triangle[k])];
    const Vec3 face = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    if (!(face.norm() > 0)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto vertex = static_cast<std::size_t>(triangle[k]);
      normals[static_cast<std::size_t>(first[vertex])] +=
          corner_angle(corner[(k + 1) % 3] - corner[k], corner[(k + 2) % 3] - corner[k]) *
          face.normalized();
    }
  }
  // First vertices come before the others at their place, so that they are ready when copied.
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const auto own = static_cast<std::size_t>(first[i]);
    if (own != i) {
      normals[i] = normals[own];
    } else if (normals[i].norm() > 1e-12) {
      normals[i].normalize();
    } else {
      normals[i].setZero();
    }
  }
  return normals;
}

}  // namespace carillon::render
