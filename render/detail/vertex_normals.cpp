#include "render/detail/vertex_normals.hpp"

#include <Eigen/Geometry>
#include <array>

#include "solvers/mesh/weld.hpp"

namespace carillon::render {

std::vector<Vec3> vertex_normals(const std::vector<Vec3>& vertices,
                                 const std::vector<solvers::mesh::Triangle>& triangles) {
  const std::vector<std::int32_t> first = solvers::mesh::first_at_place(vertices);
  std::vector<Vec3> normals(vertices.size(), Vec3(Vec3::Zero()));
  for (const solvers::mesh::Triangle& triangle : triangles) {
    std::array<Vec3, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) corner[k] = vertices[static_cast<std::size_t>(triangle[k])];
    const Vec3 face = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    if (!(face.norm() > 0)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto vertex = static_cast<std::size_t>(triangle[k]);
      normals[static_cast<std::size_t>(first[vertex])] +=
          solvers::mesh::angle_between(corner[(k + 1) % 3] - corner[k],
                                       corner[(k + 2) % 3] - corner[k]) *
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
