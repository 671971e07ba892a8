#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "dataset/run/build.hpp"

namespace carillon::dataset::run {

/// Writes the resolved configuration, and the fingerprint of what was read with it, into a folder
/// that is new or was made by the same configuration or one that this one adds to: objects,
/// strikes, materials or sizes more, everything else the same. Any other folder is refused.
/// @param entries  of the folder's journal
/// @throws ConfigError   with the lines that differ
/// @throws StorageError  it cannot be written
void claim_folder(const LoadedBuild& build, const std::filesystem::path& output,
                  const std::map<std::string, nlohmann::json>& entries);

}  // namespace carillon::dataset::run
