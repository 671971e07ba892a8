#pragma once

#include <mpi.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/tell.hpp"
#include "mpi/task_board.hpp"

namespace carillon::eval::studies {

/// One stage of an evaluation: tasks of single ranks, each of which keeps what it finds.
struct Stage {
  std::string name;              ///< for the line of progress and in the trace
  std::vector<mpi::Task> tasks;  ///< the host's
  std::vector<bool> done;        ///< of them, by an earlier run
  /// What a task does.
  /// @return one line of JSON
  std::function<std::string(std::int64_t task)> work;
  /// A task ended well, with that line; called on the host, one at a time. May be empty.
  std::function<void(std::int64_t task, const nlohmann::json& record)> completed{};
  core::Tell tell_interrupted{};  ///< says once that the run was cut short; may be empty
};

/// How a stage ended; the same on every rank.
struct StageEnd {
  bool interrupted = false;
  std::int64_t tasks_run = 0;
  double seconds = 0;                      ///< the host's clock
  double rank_seconds = 0;                 ///< of all tasks together
  std::vector<nlohmann::json> failures{};  ///< `task, kind, message, hint`, by task
};

/// Runs what is left to do on all ranks. Signals end it; what is kept stays.
/// @throws  what `completed` threw, StorageError where a task met it; on every rank alike
/// @note Collective on world.
StageEnd run_stage(const Stage& stage, MPI_Comm world);

}  // namespace carillon::eval::studies
