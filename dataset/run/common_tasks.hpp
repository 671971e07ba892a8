#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "dataset/run/build.hpp"
#include "dataset/samples/modes_task.hpp"
#include "mpi/task_board.hpp"

namespace carillon::dataset::run {

/// One of the datasets that a run works on.
struct BuildRun {
  LoadedBuild build;
  samples::BuildFolders folders;
  std::string name{};  ///< before its tasks' keys on the common board; "" for a build alone
};

/// Tasks that do the same work, by their numbers on the board: where one task fails in a stage
/// ("mesh", "solve"), the others would fail likewise, and are given up with it.
using SameWork = std::map<std::pair<std::int64_t, std::string>, std::vector<std::int64_t>>;

/// The tasks of a run's builds on its board, one build after the other.
struct CommonTasks {
  std::vector<mpi::Task> tasks{};
  std::vector<std::size_t> first{};  ///< where each build's tasks begin, and the number of all
  std::vector<bool> done{};          ///< by an earlier run
};

/// @return with keys that begin with the builds' names, as if nothing were done
CommonTasks common_tasks(const std::vector<BuildRun>& builds);

/// May make tasks of different builds wait for each other, and says which of them do the same.
using OrderTasks = std::function<SameWork(CommonTasks&)>;

}  // namespace carillon::dataset::run
