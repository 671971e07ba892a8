#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mpi/task_board.hpp"

namespace carillon::dataset::run {

/// What the tasks of an earlier build took, beside what was estimated for them [s]. What other
/// programs, or more ranks than processors, took of the processors meanwhile does not count.
struct MeasuredTime {
  double estimate = 0;
  double seconds = 0;
  std::string kind{};  ///< as mpi::Task::kind
};
using MeasuredTimes = std::map<std::string, MeasuredTime>;  ///< by the task's key, as on its board

/// Reads a dataset's trace.json, or, where it lists no tasks, the journal beside it. Estimates are
/// those that this program makes for the configuration that lies there; the trace's own where it is
/// missing (as in a sweep's folder), or cannot be read.
/// @param path  the folder of a dataset or sweep, or its trace.json
/// @throws FileError, InputError  there is no such folder, or nothing in it tells of a task
MeasuredTimes read_measured_times(const std::filesystem::path& path);

/// Seconds of each task of a board, in its order.
struct TaskSeconds {
  std::vector<double> seconds;
  std::size_t measured = 0;  ///< tasks whose own time is known
  /// Measured over estimated: of "modes" (those of groups among them), "samples" and, where there
  /// are such, "modes from cache"; 1 where none is known.
  std::map<std::string, double> ratio;
};

/// A task that the earlier build had, with the same estimate (so it is the same piece of work),
/// takes what it took there; others take their estimate times the ratio of their kind.
TaskSeconds expected_seconds(const std::vector<mpi::Task>& tasks, const MeasuredTimes& measured);

}  // namespace carillon::dataset::run
