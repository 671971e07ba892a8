#pragma once

#include <limits>

namespace carillon::core {

/// A number that is not determined.
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace carillon::core
