#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/build/build.hpp"
#include "cli/build/machine_costs.hpp"

namespace carillon::cli {

struct ScheduleOptions {
  std::vector<int> ranks{};  ///< one simulation each
  int ranks_per_node = 0;    ///< 0: all ranks on one node
  std::string trace{};       ///< dataset whose task times count instead of estimates; "" for none
};

/// How the build would go on so many ranks, by mpi::simulate().
///
/// @return `tasks: {count, measured, ratio: {modes, samples}, longest, longest_s}`,
///         `files: {count, modes, shards, wav, png, shard_bytes, largest_shard_bytes,
///         largest_folder}`, `schedules`, for each number of ranks `{ranks, nodes, start_s,
///         makespan_s, index_s, wall_s, efficiency, all_at_work_until_s, half_at_work_until_s,
///         straggler_share, shared_work_s, longest_chain_s, last_task, idle_s, node_memory_bytes,
///         limited_by, service: {requests_per_s, capacity_per_s, repeats_per_s, host_busy,
///         mean_answer_s, longest_answer_s}}`. docs/scaling.md says what they mean.
/// @throws InputError, FileError  numbers below 1; a trace that cannot be read
nlohmann::json simulate_build(const LoadedBuild& build, const ScheduleOptions& options,
                              const MachineCosts& costs = {});

/// The same for a person: what the tasks are, a table with a line for each number of ranks.
std::string schedule_text(const nlohmann::json& simulated);

}  // namespace carillon::cli
