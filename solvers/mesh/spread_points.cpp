#include "solvers/mesh/spread_points.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace carillon::solvers::mesh {

std::vector<SpreadPoint> spread_points(const SurfaceMesh& surface, std::size_t count) {
  constexpr double plastic = 1.32471795724474602596;
  const double share = area(surface) / static_cast<double>(count);
  std::vector<SpreadPoint> points;
  double owed = 0, u = 0.5, v = 0.5;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto corner = [&](std::size_t i) {
      return surface.vertices[static_cast<std::size_t>(surface.triangles[t][i])];
    };
    const Vec3 a = corner(0), b = corner(1) - a, c = corner(2) - a;
    owed += b.cross(c).norm() / 2 / share;
    const auto due = static_cast<std::size_t>(owed);
    owed -= static_cast<double>(due);
    for (std::size_t k = 0; k < due; ++k) {
      u = std::fmod(u + 1 / plastic, 1.0);
      v = std::fmod(v + 1 / (plastic * plastic), 1.0);
      const bool outside = u + v > 1;
      points.push_back({a + (outside ? 1 - u : u) * b + (outside ? 1 - v : v) * c, t});
    }
  }
  return points;
}

}  // namespace carillon::solvers::mesh
