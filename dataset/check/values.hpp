#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/check/report.hpp"

namespace carillon::dataset::check {

/// What the values of a shard are: lines that begin with a sample's key.
struct ValueScan {
  std::size_t samples = 0;
  std::vector<std::string> broken{};  ///< what is not finite or does not fit
  std::vector<std::string> clipped{}, silent{};
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ValueScan, samples, broken, clipped, silent)

/// Reads every value of a shard.
/// @throws FileError
ValueScan scan_values(const std::filesystem::path& shard);

/// From the scans of all shards: values, clipping, silence.
std::vector<Finding> judge_values(const std::vector<ValueScan>& scans);

}  // namespace carillon::dataset::check
