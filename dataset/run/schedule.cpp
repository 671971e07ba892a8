#include "dataset/run/schedule.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "dataset/plan/disk.hpp"
#include "dataset/run/costs.hpp"
#include "dataset/run/detail/measured_times.hpp"

namespace carillon::dataset::run {

namespace {

void add_files(const LoadedBuild& build, FileCounts& files) {
  const plan::BuildPlan& plan = build.plan;
  std::size_t shards = 0, maximum = 0;
  for (const plan::BuildTask& task : plan.tasks) {
    if (task.kind != plan::TaskKind::samples) continue;
    ++shards;
    maximum = std::max(maximum, task.count);
  }
  const std::size_t wav = build.config.wav ? plan.samples.size() : 0;
  std::vector<std::size_t> sounds(plan.shapes.size(), 0);  // a folder for each shape
  for (const plan::Sample& sample : plan.samples) ++sounds[sample.shape];
  const std::size_t largest_sounds =
      wav > 0 ? *std::max_element(sounds.begin(), sounds.end()) : std::size_t{0};
  const plan::SampleBytes each = plan::sample_bytes(build.config);
  const double bytes = each.total() - each.wav;
  files.modes += plan.shapes.size();
  files.shards += shards;
  files.wav += wav;
  if (build.config.png) files.png += plan::pictures(plan) * build.config.cameras.size();
  files.others +=
      8;  // index, dataset, croissant, failures, warnings, configuration, journal, trace
  files.shard_bytes += bytes * static_cast<double>(plan.samples.size());
  files.largest_shard_bytes =
      std::max(files.largest_shard_bytes, bytes * static_cast<double>(maximum));
  files.largest_folder =
      std::max({files.largest_folder, plan.shapes.size(), shards, largest_sounds});
}

FileCounts count_files(std::span<const LoadedBuild> builds) {
  FileCounts files;
  for (const LoadedBuild& build : builds) add_files(build, files);
  if (builds.size() > 1) files.others += 4;  // a sweep's two tables, sweep.json and trace.json
  ++files.others;                            // the run's status.json
  return files;
}

std::filesystem::path trace_file(const std::filesystem::path& path) {
  return std::filesystem::is_directory(path) ? path / "trace.json" : path;
}

/// What keeps the build from being faster on so many ranks.
std::string limit_of(const mpi::Schedule& schedule) {
  if (schedule.makespan <= 0) return "nothing";
  if (schedule.longest_chain > 0.8 * schedule.makespan) return "longest chain";
  if (schedule.shared_work > 0.8 * schedule.makespan) return "work";
  if (schedule.memory_wait > 0.5 * schedule.idle) return "memory of nodes";
  return "order of tasks";
}

}  // namespace

SimulatedBuild simulate_builds(std::span<const LoadedBuild> builds,
                               const std::vector<mpi::Task>& tasks,
                               const ScheduleOptions& options) {
  for (const int ranks : options.ranks) {
    if (ranks < 1 || options.ranks_per_node < 0) {
      throw core::InputError("--ranks and --ranks-per-node are numbers from 1 up");
    }
  }
  MeasuredTimes measured;
  if (!options.trace.empty()) measured = read_measured_times(options.trace);
  const TaskSeconds times = expected_seconds(tasks, measured);
  const auto longest =
      std::max_element(times.seconds.begin(), times.seconds.end()) - times.seconds.begin();
  SimulatedBuild out{.tasks = tasks.size(),
                     .measured = times.measured,
                     .ratio = times.ratio,
                     .longest = tasks[static_cast<std::size_t>(longest)].key,
                     .longest_s = times.seconds[static_cast<std::size_t>(longest)],
                     .files = count_files(builds)};
  if (!options.trace.empty()) out.last_run = plan::last_run(trace_file(options.trace));
  const std::int64_t given = builds.front().config.ranks.memory_per_node;
  for (const int ranks : options.ranks) {
    const int on_node = options.ranks_per_node > 0 ? options.ranks_per_node : ranks;
    const auto idle = static_cast<std::int64_t>(idle_rank_bytes) * std::min(on_node, ranks);
    const mpi::SimulatedRanks on{
        .ranks = ranks,
        .ranks_per_node = on_node,
        .node_memory = given > 0 ? std::max<std::int64_t>(1, given - idle) : 0};
    const mpi::Schedule went = mpi::simulate(mpi::TaskBoard(tasks), times.seconds, on);
    const auto last = static_cast<std::size_t>(went.last_task);
    out.schedules.push_back({on, went, went.last_task < 0 ? "" : tasks[last].key, limit_of(went)});
  }
  return out;
}

SimulatedBuild simulate_build(const LoadedBuild& build, const ScheduleOptions& options) {
  return simulate_builds({&build, 1}, board_tasks(build.plan, build.config), options);
}

}  // namespace carillon::dataset::run
