#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dataset/plan/task_times.hpp"
#include "dataset/run/build.hpp"
#include "mpi/simulation.hpp"

namespace carillon::dataset::run {

struct ScheduleOptions {
  std::vector<int> ranks{};  ///< one simulation each
  int ranks_per_node = 0;    ///< 0: all ranks on one node
  std::string trace{};  ///< dataset or sweep whose task times count instead of estimates, or ""
};

/// The files of datasets.
struct FileCounts {
  std::size_t modes = 0, shards = 0, wav = 0, png = 0, others = 0;
  double shard_bytes = 0, largest_shard_bytes = 0;
  std::size_t largest_folder = 0;  ///< files in it
};

/// A build on so many ranks.
struct SimulatedSchedule {
  mpi::SimulatedRanks on{};
  mpi::Schedule went{};
  std::string last_task{};   ///< key of the one that ended last, or ""
  std::string limited_by{};  ///< what keeps the build from being faster
};

/// Builds on one board, on as many ranks as were asked for. docs/scaling.md says what it means.
struct SimulatedBuild {
  std::size_t tasks = 0;
  std::size_t measured = 0;               ///< tasks whose own time is known
  std::map<std::string, double> ratio{};  ///< measured over estimated, by kind of task
  std::string longest{};                  ///< key of the longest task
  double longest_s = 0;
  FileCounts files{};
  std::optional<plan::RunRecord> last_run{};  ///< the trace's
  std::vector<SimulatedSchedule> schedules{};
};

/// How builds on one board would go on so many ranks, by mpi::simulate(). Nodes have the
/// `ranks.memory_per_node` of the first; 0 is without bounds.
///
/// @param tasks  of all builds, one after the other in the order of their plans
/// @throws InputError, FileError  numbers below 1; a trace that cannot be read
SimulatedBuild simulate_builds(std::span<const LoadedBuild> builds,
                               const std::vector<mpi::Task>& tasks, const ScheduleOptions& options);

/// The same of a build alone.
SimulatedBuild simulate_build(const LoadedBuild& build, const ScheduleOptions& options);

/// `tasks: {count, measured, ratio: {modes, samples}, longest, longest_s}`, `last_run` (as
/// trace.json has it in `runs`; only where there is one), `files: {count, modes, shards, wav, png,
/// shard_bytes, largest_shard_bytes, largest_folder}`, `schedules`, for each number of ranks
/// `{ranks, nodes, makespan_s, efficiency, all_at_work_until_s, half_at_work_until_s,
/// straggler_fraction, shared_work_s, longest_chain_s, last_task, idle_s, memory_wait_s,
/// refused_tasks, node_memory_bytes, limited_by}`.
nlohmann::json to_json(const SimulatedBuild& simulation);

/// The same for a person: what the tasks are, a table with a line for each number of ranks, and
/// what is refused for want of memory.
std::string simulation_text(const SimulatedBuild& simulation);

}  // namespace carillon::dataset::run
