#pragma once

#include <Eigen/Core>

namespace carillon {

/// A point or a direction.
using Vec3 = Eigen::Vector3d;

}  // namespace carillon
