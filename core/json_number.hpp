#pragma once

#include <cmath>
#include <nlohmann/json.hpp>

namespace carillon::core {

/// A number, or null where there is none: JSON knows neither NaN nor infinity.
inline nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

}  // namespace carillon::core
