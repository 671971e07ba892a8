#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "cli/build/build.hpp"

namespace carillon::cli {

/// What the tasks of an earlier build took, beside what was estimated for them [s].
struct MeasuredTime {
  double estimate = 0;
  double seconds = 0;
};
using MeasuredTimes = std::map<std::string, MeasuredTime>;  ///< by the task's key

/// Reads a dataset's trace.json, or, where it lists no tasks, the journal beside it. Estimates are
/// those that this program makes for the configuration that lies there; the trace's own where it is
/// missing, or cannot be read.
/// @param path  the dataset's folder, or its trace.json
/// @throws FileError, InputError  there is no such folder, or nothing in it tells of a task
MeasuredTimes read_measured_times(const std::filesystem::path& path);

/// Seconds of each task of a build, in the order of its plan.
struct TaskSeconds {
  std::vector<double> seconds;
  std::size_t measured = 0;             ///< tasks whose own time is known
  std::map<std::string, double> ratio;  ///< measured over estimated, by kind; 1 where none is known
};

/// A task that the earlier build had, with the same estimate (so it is the same piece of work),
/// takes what it took there; others take their estimate times the ratio of their kind.
/// @param estimates  of the tasks [s], in the order of the plan
TaskSeconds expected_seconds(const BuildPlan& plan, const std::vector<double>& estimates,
                             const MeasuredTimes& measured);

}  // namespace carillon::cli
