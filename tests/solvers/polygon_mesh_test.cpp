// Polygons cut into triangles.
#include "solvers/mesh/readers/detail/polygon_mesh.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <vector>

namespace carillon::solvers {
namespace {

/// A star-shaped polygon around the z axis, tilted; concave when radii vary.
std::vector<Vec3> star(const std::vector<double>& radii) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const double angle = 2 * M_PI * static_cast<double>(i) / static_cast<double>(radii.size());
    const double x = radii[i] * std::cos(angle);
    const double y = radii[i] * std::sin(angle);
    points.emplace_back(x, 0.6 * y, 0.8 * y);
  }
  return points;
}

TEST(TriangulatePolygon, CoversEveryStarOnce) {
  EXPECT_TRUE(rc::check("areas add up and no triangle is turned over", [] {
    const auto corners = *rc::gen::inRange<std::size_t>(3, 40);
    std::vector<double> radii;
    for (std::size_t i = 0; i < corners; ++i) radii.push_back(*rc::gen::inRange(1, 100) / 10.0);
    const auto points = star(radii);
    std::vector<std::int32_t> polygon(corners);
    for (std::size_t i = 0; i < corners; ++i) polygon[i] = static_cast<std::int32_t>(i);
    std::vector<mesh::Triangle> triangles;
    mesh::readers::triangulate_polygon(points, polygon, triangles);
    RC_ASSERT(triangles.size() == corners - 2);
    // Shoelace formula in polar coordinates against the sum over triangles.
    double expected = 0;
    for (std::size_t i = 0; i < corners; ++i) {
      expected += radii[i] * radii[(i + 1) % corners] / 2 *
                  std::sin(2 * M_PI / static_cast<double>(corners));
    }
    double sum = 0;
    for (const mesh::Triangle& t : triangles) {
      const Vec3 a =
          points[static_cast<std::size_t>(t[1])] - points[static_cast<std::size_t>(t[0])];
      const Vec3 b =
          points[static_cast<std::size_t>(t[2])] - points[static_cast<std::size_t>(t[0])];
      const double part = a.cross(b).dot(Vec3(0, -0.8, 0.6)) / 2;
      RC_ASSERT(part > -1e-9);
      sum += part;
    }
    RC_ASSERT(std::abs(sum - expected) < 1e-9 * expected);
  }));
}

}  // namespace
}  // namespace carillon::solvers
