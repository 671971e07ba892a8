#pragma once

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/numbers.hpp"

namespace carillon::core {

/// A number, or null where there is none: JSON knows neither NaN nor infinity.
inline nlohmann::json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

/// The way back: NaN for null.
inline double number_or_nan(const nlohmann::json& value) {
  return value.is_null() ? nan : value.get<double>();
}

/// The document of a file; null where there is no file, or what is in it is no JSON, or only the
/// beginning of some.
/// @throws FileError  cannot be read
nlohmann::json read_json(const std::filesystem::path& path);
/// The same with its keys in the order of the file.
nlohmann::ordered_json read_ordered_json(const std::filesystem::path& path);

}  // namespace carillon::core
