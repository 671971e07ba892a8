#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "dataset/run/build.hpp"
#include "mpi/task_board.hpp"

namespace carillon::dataset::run {

struct ScheduleOptions {
  std::vector<int> ranks{};  ///< one simulation each
  int ranks_per_node = 0;    ///< 0: all ranks on one node
  std::string trace{};  ///< dataset or sweep whose task times count instead of estimates, or ""
};

/// How builds on one board would go on so many ranks, by mpi::simulate(). Nodes have the
/// `ranks.memory_per_node` of the first; 0 is without bounds.
///
/// @param tasks  of all builds, one after the other in the order of their plans
/// @return `tasks: {count, measured, ratio: {modes, samples}, longest, longest_s}`, `last_run` (the
///         trace's, as trace.json has it in `runs`; only where there is one),
///         `files: {count, modes, shards, wav, png, shard_bytes, largest_shard_bytes,
///         largest_folder}`, `schedules`, for each number of ranks `{ranks, nodes, makespan_s,
///         efficiency, all_at_work_until_s, half_at_work_until_s, straggler_fraction,
///         shared_work_s, longest_chain_s, last_task, idle_s, memory_wait_s, refused_tasks,
///         node_memory_bytes, limited_by}`. docs/scaling.md says what they mean.
/// @throws InputError, FileError  numbers below 1; a trace that cannot be read
nlohmann::json simulate_builds(std::span<const LoadedBuild> builds,
                               const std::vector<mpi::Task>& tasks, const ScheduleOptions& options);

/// The same of a build alone.
nlohmann::json simulate_build(const LoadedBuild& build, const ScheduleOptions& options);

/// The same for a person: what the tasks are, a table with a line for each number of ranks, and
/// what is refused for want of memory.
std::string schedule_text(const nlohmann::json& simulated);

}  // namespace carillon::dataset::run
