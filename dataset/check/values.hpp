#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <vector>

#include "dataset/check/report.hpp"

namespace carillon::dataset::check {

/// Reads every value of a shard.
/// @return {samples, broken[]: what is not finite or does not fit, clipped[], silent[]: keys}
/// @throws FileError
nlohmann::json scan_values(const std::filesystem::path& shard);

/// From the scans of all shards: values, clipping, silence.
std::vector<Finding> judge_values(const std::vector<nlohmann::json>& scans);

}  // namespace carillon::dataset::check
