#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "dataset/run/build.hpp"

namespace carillon::dataset::stored {

/// A dataset's folder, and the build that made it.
struct StoredDataset {
  std::filesystem::path folder;
  std::string configuration;           ///< text of the resolved configuration
  nlohmann::json description;          ///< dataset.json; null where there is none that can be read
  std::vector<std::string> overrides;  ///< where the files are that the configuration names
  std::vector<std::string> tried;      ///< folders in which they were looked for
  run::LoadedBuild build;
  std::vector<std::string>
      doubts;  ///< files that differ from what was built from, or are not there
};

/// What is wrong with a folder in which a dataset was looked for: what it is, and which commands
/// take it.
core::InputError not_a_dataset(const std::filesystem::path& folder);

/// Opens a dataset from its folder alone. Small inputs are read from its `inputs/`, mesh files are
/// known from dataset.json; only recordings of noise (and, without dataset.json, meshes) are looked
/// for elsewhere.
/// @param inputs         the folder that paths of the configuration are meant from; "": the one the
///                       build noted, the dataset's, the one above it, the current one
/// @param configuration  instead of the folder's own
/// @throws InputError, ConfigError  it is no dataset, or its configuration cannot be read
StoredDataset open_dataset(const std::filesystem::path& folder, const std::string& inputs,
                           const std::optional<std::string>& configuration = {});

/// The same build with other values of some keys.
/// @param overrides  key=value
run::LoadedBuild changed_build(const StoredDataset& dataset,
                               const std::vector<std::string>& overrides);

/// @throws InputError  files that effects of the build need are not there; says where they were
///                     looked for
void require_inputs(const StoredDataset& dataset, const configuration::BuildConfig& config);

/// A library's version; null where a side does not have it.
struct OtherVersion {
  nlohmann::json stored{}, here{};
};
using OtherVersions = std::map<std::string, OtherVersion>;  ///< by name

/// Libraries whose versions are others than those of the build.
OtherVersions other_versions(const StoredDataset& dataset);

}  // namespace carillon::dataset::stored
