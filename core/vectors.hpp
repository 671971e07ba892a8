#pragma once

#include <Eigen/Core>

namespace carillon {

/// A point or a direction: in space, and in a plane.
using Vec3 = Eigen::Vector3d;
using Vec2 = Eigen::Vector2d;

}  // namespace carillon
