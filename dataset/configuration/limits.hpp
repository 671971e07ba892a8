#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>

#include "core/config.hpp"
#include "core/time_limit.hpp"
#include "core/trace.hpp"
#include "solvers/mesher/mesh_child.hpp"

namespace carillon::mpi {
class RunningTask;
}

namespace carillon::dataset::configuration {

/// What a task may take before it counts as failed: `limits:` of a configuration. Limits fail
/// tasks; they choose nothing, so that no value depends on them (solver.memory_limit does choose,
/// and is judged by the matrix alone).
struct TaskLimits {
  solvers::mesher::ChildLimits mesh;  ///< of the mesher's process
  double solve_time = 0;          ///< of one solve of an object in all its materials [s]; 0: none
  std::int64_t solve_memory = 0;  ///< data of a rank's process while it solves [byte]; 0: none
  double sample_time = 0;         ///< of one sound [s]; 0: none
};

/// @throws ConfigError
TaskLimits read_limits(core::ConfigNode node);

/// Clocks that begin now.
core::TimeLimit solve_clock(const TaskLimits& limits);
core::TimeLimit sample_clock(const TaskLimits& limits);

/// Runs `solve` while allocations that would take this process beyond the limit fail.
/// @throws MemoryError  naming the limit, in place of std::bad_alloc and of other MemoryErrors
void within_memory(std::int64_t limit, const std::function<void()>& solve);

/// Runs a task that is noted while it runs. Ends the process where a part of it goes on for half as
/// long again as its limit (two seconds longer at least): then it did not heed its clock.
/// @param trace  through which the task tells its parts
/// @param group  the task's ranks; what any of them throws, all do (mpi::agree_at_end)
/// @throws core::TaskError  for any error of the task, with part and item
/// @note Collective on group.
void watch_task(mpi::RunningTask& running, const TaskLimits& limits, const std::string& task,
                core::Trace& trace, MPI_Comm group, const std::function<void()>& work);

}  // namespace carillon::dataset::configuration
