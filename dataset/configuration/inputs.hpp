#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dataset/configuration/configuration.hpp"

namespace carillon::dataset::configuration {

/// A small file that a configuration names: own materials, given strikes, the profile of a turned
/// object.
struct InputFile {
  std::string key;   ///< of the configuration, dotted: "strikes.csv"
  std::string path;  ///< where it was read
};
std::vector<InputFile> input_files(const BuildConfig& config);

/// Copies those files into `inputs/` of a dataset, each named as its key, so that its samples can
/// be made again from the folder alone. Meshes and recordings are not copied.
/// @throws FileError
void keep_inputs(const BuildConfig& config, const std::filesystem::path& output);

/// The folder that the paths of a configuration are meant from.
std::string configuration_folder(const std::string& config_path);

}  // namespace carillon::dataset::configuration
