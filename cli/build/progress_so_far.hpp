#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/build/build.hpp"
#include "cli/build/modes_task.hpp"
#include "mpi/journal.hpp"

namespace carillon::cli {

/// Journal entry of each task that ended, by its key; a later entry counts more than an earlier
/// one. A task whose files are not there any more, whole, is not among them.
std::map<std::string, nlohmann::json> finished_tasks(const mpi::Journal& journal,
                                                     const std::filesystem::path& output);

/// Writes the resolved configuration, and the fingerprint of what was read with it, into a new
/// folder; refuses a folder that another configuration or other files made.
/// @throws ConfigError  with the lines that differ
void claim_folder(const LoadedBuild& build, const std::filesystem::path& output);

/// `path, sha256, bytes` of files, for journal and dataset.json.
nlohmann::json describe_files(const std::vector<std::string>& written,
                              const std::filesystem::path& output);

/// What a folder holds.
struct Results {
  std::size_t samples = 0;          ///< in the index
  std::size_t failed = 0;           ///< tasks
  std::vector<std::string> missed;  ///< shapes that did not meet the pitch target
};

/// Writes index.h5, dataset.json and failures.json from all that is finished.
Results write_results(const LoadedBuild& build, const BuildFolders& folders,
                      const std::map<std::string, nlohmann::json>& finished);

}  // namespace carillon::cli
