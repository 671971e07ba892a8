#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset/plan/task_times.hpp"
#include "dataset/run/run_builds.hpp"

namespace carillon::dataset::run {

/// What a folder's trace.json says, but for what the run as a whole has to say.
struct FolderTrace {
  core::Trace ran{};  ///< by all finished tasks
  std::optional<std::string> configuration_folder{};
  std::size_t missed_pitch_targets = 0;
  std::vector<plan::TaskRow> tasks{};
};

/// Of a dataset's folder.
FolderTrace folder_trace(const LoadedBuild& build,
                         const std::map<std::string, nlohmann::json>& finished,
                         const Results& results);

/// Writes a folder's trace.json where it does not say so yet: a run that was killed may have ended
/// all tasks and not have come to it. `runs` of the folder's old one are kept.
/// @param outcome  where ranks worked on this folder alone: what the run says of itself is added
///                 (`runs`, `ranks`, `index`) if it ran tasks. Null for one of several builds
/// @param made     of mpi::made_by(), for what the run says
/// @return what the run says of itself, where it was added
std::optional<plan::RunRecord> keep_trace(const std::filesystem::path& folder,
                                          const FolderTrace& trace, const RunOutcome* outcome,
                                          const nlohmann::json& made);

}  // namespace carillon::dataset::run
