#include <Eigen/Geometry>
#include <algorithm>

#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"

namespace carillon::solvers::mesh::repair {

SurfaceMesh thicken(const SurfaceMesh& sheet, double thickness) {
  const auto corner = [&sheet](const Triangle& t, std::size_t i) -> const Vec3& {
    return sheet.vertices[static_cast<std::size_t>(t[i])];
  };
  // Normals weighted by the angle at the vertex (Thuermer and Wuethrich 1998).
  std::vector<Vec3> direction(sheet.vertices.size(), Vec3::Zero());
  for (const Triangle& t : sheet.triangles) {
    const Vec3 normal =
        (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).normalized();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 a = corner(t, (i + 1) % 3) - corner(t, i);
      const Vec3 b = corner(t, (i + 2) % 3) - corner(t, i);
      direction[static_cast<std::size_t>(t[i])] += angle_between(a, b) * normal;
    }
  }
  for (Vec3& d : direction) d.normalize();
  // At a crease the offset faces meet further out than half the thickness. The mean of the cosines
  // between the direction and the faces tells how far; sharper creases than 60 degrees are blunted.
  std::vector<double> cosines(sheet.vertices.size(), 0);
  std::vector<int> faces(sheet.vertices.size(), 0);
  for (const Triangle& t : sheet.triangles) {
    const Vec3 normal =
        (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).normalized();
    for (const std::int32_t v : t) {
      cosines[static_cast<std::size_t>(v)] += normal.dot(direction[static_cast<std::size_t>(v)]);
      ++faces[static_cast<std::size_t>(v)];
    }
  }

  SurfaceMesh body;
  const auto count = static_cast<std::int32_t>(sheet.vertices.size());
  body.vertices.resize(2 * sheet.vertices.size());
  for (std::size_t v = 0; v < sheet.vertices.size(); ++v) {
    const double cosine = std::max(0.5, cosines[v] / std::max(1, faces[v]));
    const Vec3 offset = thickness / 2 / cosine * direction[v];
    body.vertices[v] = sheet.vertices[v] + offset;
    body.vertices[v + sheet.vertices.size()] = sheet.vertices[v] - offset;
  }
  body.triangles = sheet.triangles;
  for (const Triangle& t : sheet.triangles) {
    body.triangles.push_back({t[0] + count, t[2] + count, t[1] + count});
  }
  for_each_edge(edge_uses(sheet.triangles), [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 1) return;
    const std::int32_t a = edge[0].forward ? edge[0].low : edge[0].high;
    const std::int32_t b = edge[0].forward ? edge[0].high : edge[0].low;
    body.triangles.push_back({b, a, a + count});
    body.triangles.push_back({b, a + count, b + count});
  });
  return body;
}

}  // namespace carillon::solvers::mesh::repair
