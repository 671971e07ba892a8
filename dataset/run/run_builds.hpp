#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/trace.hpp"
#include "dataset/run/common_tasks.hpp"
#include "dataset/run/progress_so_far.hpp"
#include "mpi/task_service.hpp"

namespace carillon::dataset::run {

/// What the host says last when a signal cuts the run off.
/// @param results  of each build
using TellInterrupted =
    std::function<void(const std::vector<Results>& results, std::int64_t tasks_run)>;

/// Datasets that are built in one run.
struct RunRequest {
  const std::vector<BuildRun>& builds;
  std::filesystem::path output;  ///< where the run as a whole keeps what it keeps
  std::string name;              ///< of the dataset or the sweep
  bool retry_failed = false;
  OrderTasks order{};
  TellInterrupted tell_interrupted{};
};

/// A build as a run leaves it; empty but on the host.
struct EndedBuild {
  std::map<std::string, nlohmann::json> finished{};  ///< journal entries by task
  std::int64_t tasks_run = 0;
  Results results{};  ///< what the folder holds, as index.h5, dataset.json and failures.json say
};

/// How a run ended. What is not `interrupted` is the host's.
struct RunOutcome {
  bool interrupted = false;
  std::vector<EndedBuild> builds;
  int run = 1;  ///< 1, 2, ...: as the trace counts
  std::vector<mpi::RankTimes> ranks{};
  mpi::Calibration calibration{};
  core::Trace::Entry index{};  ///< keeping index.h5 up to date
  std::int64_t tasks_run() const;
};

/// Ranks of a build that was killed take a few seconds to go: how long to wait for its lock [s].
constexpr double lock_timeout_s = 10;

/// Runs what is left to do of all builds on one board, so that no rank is idle while another has
/// tasks; claims their folders and writes their journals and indices. Then calls `finish` on every
/// rank, while signals are still those of the run.
///
/// The folders are locked by the caller.
/// @return what `finish` returned on the host
/// @throws ConfigError, FileError, StorageError  a folder was built from something else, or cannot
///         be written; on every rank alike
/// @note Collective on world.
int run_builds(const RunRequest& request, MPI_Comm world,
               const std::function<int(RunOutcome&)>& finish);

}  // namespace carillon::dataset::run
