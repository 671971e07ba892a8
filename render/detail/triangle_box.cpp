#include "render/detail/triangle_box.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace carillon::render {

bool triangle_meets_box(const std::array<Vec3, 3>& triangle, const Vec3& centre,
                        const Vec3& half_extent, double tolerance) {
  const std::array<Vec3, 3> corner = {triangle[0] - centre, triangle[1] - centre,
                                      triangle[2] - centre};
  const auto separated = [&](const Vec3& axis) {
    const double a = axis.dot(corner[0]);
    const double b = axis.dot(corner[1]);
    const double c = axis.dot(corner[2]);
    const double reach = half_extent.dot(axis.cwiseAbs()) + tolerance * axis.norm();
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  const std::array<Vec3, 3> edge = {corner[1] - corner[0], corner[2] - corner[1],
                                    corner[0] - corner[2]};
  for (int axis = 0; axis < 3; ++axis) {
    if (separated(Vec3::Unit(axis))) return false;
  }
  if (separated(edge[0].cross(edge[1]))) return false;
  for (int axis = 0; axis < 3; ++axis) {
    for (const Vec3& side : edge) {
      if (separated(Vec3::Unit(axis).cross(side))) return false;
    }
  }
  return true;
}

}  // namespace carillon::render
