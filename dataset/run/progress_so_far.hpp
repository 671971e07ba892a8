#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/run/build.hpp"
#include "dataset/run/check_files.hpp"
#include "dataset/run/joined_files.hpp"
#include "dataset/samples/modes_task.hpp"

namespace carillon::dataset::run {

/// Journal entry of each task that ended, by its key; a later entry counts more than an earlier
/// one, and a failure that hung on the moment leaves its task open. Whether its files are still
/// there is check_files.hpp's matter.
std::map<std::string, nlohmann::json> finished_tasks(const std::vector<nlohmann::json>& journal);

/// Files that were written, for journal and dataset.json.
std::vector<ListedFile> describe_files(const std::vector<std::string>& written,
                                       const std::filesystem::path& output);

/// What finished tasks add up to.
struct Gathered {
  std::vector<std::size_t> done;  ///< samples tasks of the plan, ascending
  std::size_t samples = 0;        ///< of these tasks
  std::vector<ListedFile> files;
  nlohmann::json pitch_targets = nlohmann::json::object();  ///< by a shape's id
  nlohmann::json warnings = nlohmann::json::array();        ///< {task, message} in plan order
};
Gathered gather(const plan::BuildPlan& plan, const std::map<std::string, nlohmann::json>& finished);

/// What a folder holds.
struct Results {
  std::size_t samples = 0;          ///< in the index
  std::size_t failed = 0;           ///< tasks
  std::size_t warnings = 0;         ///< of warnings.json
  std::vector<std::string> missed;  ///< shapes that did not meet the pitch target
};

/// Writes index.h5, dataset.json, failures.json and warnings.json from all that is finished.
/// @param joined  as in write_index; none: every file is read
Results write_results(const LoadedBuild& build, const samples::BuildFolders& folders,
                      const std::map<std::string, nlohmann::json>& finished, JoinedFiles& joined);
Results write_results(const LoadedBuild& build, const samples::BuildFolders& folders,
                      const std::map<std::string, nlohmann::json>& finished);

}  // namespace carillon::dataset::run
