#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "dataset/check/report.hpp"
#include "dataset/run/check_files.hpp"
#include "dataset/stored/stored_dataset.hpp"

namespace carillon::dataset::check {

/// A dataset's folder as it is found: what is there, and what should be.
struct DatasetFolder {
  stored::StoredDataset dataset;
  bool building = false;                ///< a build is writing to it now
  std::vector<run::ListedFile> listed;  ///< by dataset.json; without it: by the journal
  /// Tasks that ended, by the journal; none where it is not there or cannot be read.
  std::map<std::string, nlohmann::json> finished;
  nlohmann::json failures;                      ///< failures.json; null where there is none
  std::vector<std::size_t> present;             ///< samples tasks of the plan whose shard is there
  std::vector<std::size_t> absent;              ///< and those whose shard is not
  std::vector<Finding> findings;                ///< of opening it
  std::string path_of(std::size_t task) const;  ///< of a shard, from the folder
};

/// @throws InputError  it is no dataset
DatasetFolder open_folder(const std::filesystem::path& folder, const std::string& inputs);

/// Shards and samples against the plan.
Finding check_counts(const DatasetFolder& folder);
/// failures.json against plan and folder.
Finding check_failures(const DatasetFolder& folder);
/// What warnings.json says.
Finding check_warnings(const DatasetFolder& folder);
/// Estimated pitch errors of each object, the worst first.
Finding check_pitches(const DatasetFolder& folder);
/// Files that are no part of a dataset.
Finding check_foreign_files(const DatasetFolder& folder);

}  // namespace carillon::dataset::check
