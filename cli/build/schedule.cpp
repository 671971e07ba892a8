#include "cli/build/schedule.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "cli/build/costs.hpp"
#include "cli/build/disk.hpp"
#include "cli/build/measured_times.hpp"
#include "core/error.hpp"

namespace carillon::cli {

using nlohmann::json;

namespace {

/// The plan's tasks as the board takes them, and what each of them is expected to take.
struct Work {
  std::vector<mpi::Task> tasks;
  TaskSeconds times;
};

Work work_of(const LoadedBuild& build, const MeasuredTimes& measured, const MachineCosts& costs) {
  Work work{board_tasks(build.plan, build.config), {}};
  std::vector<double> estimates;
  for (const mpi::Task& task : work.tasks) estimates.push_back(task.cost / task.width);
  work.times = expected_seconds(build.plan, estimates, measured);
  // Measured times hold the files' already.
  for (std::size_t t = 0; t < work.tasks.size() && measured.empty(); ++t) {
    const BuildTask& task = build.plan.tasks[t];
    if (task.kind != TaskKind::samples || !build.config.wav) continue;
    work.times.seconds[t] += costs.file * static_cast<double>(task.count);
  }
  return work;
}

json describe_files(const LoadedBuild& build) {
  const BuildPlan& plan = build.plan;
  std::size_t shards = 0, most = 0;
  for (const BuildTask& task : plan.tasks) {
    if (task.kind != TaskKind::samples) continue;
    ++shards;
    most = std::max(most, task.count);
  }
  const std::size_t wav = build.config.wav ? plan.samples.size() : 0;
  const std::size_t png = build.config.png && build.config.camera ? plan.shapes.size() : 0;
  std::vector<std::size_t> sounds(plan.shapes.size(), 0);  // a folder for each shape
  for (const Sample& sample : plan.samples) ++sounds[sample.shape];
  const std::size_t largest_sounds =
      wav > 0 ? *std::max_element(sounds.begin(), sounds.end()) : std::size_t{0};
  constexpr std::size_t fixed = 6;  // index, dataset, failures, configuration, journal, trace
  const double bytes = sample_bytes(build.config);
  return {{"count", plan.shapes.size() + shards + wav + png + fixed},
          {"modes", plan.shapes.size()},
          {"shards", shards},
          {"wav", wav},
          {"png", png},
          {"shard_bytes", bytes * static_cast<double>(plan.samples.size())},
          {"largest_shard_bytes", bytes * static_cast<double>(most)},
          {"largest_folder", std::max({plan.shapes.size(), shards, largest_sounds})}};
}

/// What keeps the build from being faster on so many ranks.
std::string limit_of(const mpi::Schedule& schedule) {
  if (schedule.makespan <= 0) return "nothing";
  if (schedule.longest_chain > 0.8 * schedule.makespan) return "longest chain";
  if (schedule.shared_work > 0.8 * schedule.makespan) return "work";
  if (schedule.host_busy > 0.8 * schedule.makespan) return "task service";
  return "order of tasks";
}

json describe(const mpi::Schedule& schedule, const Work& work, const mpi::SimulatedRanks& on,
              const MachineCosts& costs, std::size_t shards) {
  const double span = schedule.makespan;
  const double index = costs.index_shard * static_cast<double>(shards);
  const auto per_second = [&](double count) { return span > 0 ? count / span : 0; };
  const auto& last = work.tasks[static_cast<std::size_t>(schedule.last_task)];
  return {{"ranks", on.ranks},
          {"nodes", (on.ranks - 1) / on.ranks_per_node + 1},
          {"start_s", costs.start},
          {"makespan_s", span},
          {"index_s", index},
          {"wall_s", costs.start + span + index},
          {"efficiency", schedule.efficiency},
          {"all_at_work_until_s", schedule.all_at_work_until},
          {"half_at_work_until_s", schedule.half_at_work_until},
          {"straggler_share", span > 0 ? 1 - schedule.all_at_work_until / span : 0},
          {"shared_work_s", schedule.shared_work},
          {"longest_chain_s", schedule.longest_chain},
          {"last_task", last.key},
          {"idle_s", schedule.idle},
          {"refused_tasks", schedule.refused},
          {"node_memory_bytes", schedule.node_memory},
          {"limited_by", limit_of(schedule)},
          {"service",
           {{"requests_per_s", per_second(schedule.requests)},
            {"capacity_per_s", 2 / (costs.service.claim + costs.service.complete)},
            {"repeats_per_s", per_second(schedule.repeats)},
            {"host_busy", per_second(schedule.host_busy)},
            {"mean_answer_s", schedule.mean_answer},
            {"longest_answer_s", schedule.longest_answer}}}};
}

}  // namespace

json simulate_build(const LoadedBuild& build, const ScheduleOptions& options,
                    const MachineCosts& costs) {
  for (const int ranks : options.ranks) {
    if (ranks < 1 || options.ranks_per_node < 0) {
      throw core::InputError("--ranks and --ranks-per-node are numbers from 1 up");
    }
  }
  MeasuredTimes measured;
  if (!options.trace.empty()) measured = read_measured_times(options.trace);
  const Work work = work_of(build, measured, costs);
  const auto longest = std::max_element(work.times.seconds.begin(), work.times.seconds.end()) -
                       work.times.seconds.begin();
  json out = {{"tasks",
               {{"count", work.tasks.size()},
                {"measured", work.times.measured},
                {"ratio", work.times.ratio},
                {"longest", work.tasks[static_cast<std::size_t>(longest)].key},
                {"longest_s", work.times.seconds[static_cast<std::size_t>(longest)]}}},
              {"files", describe_files(build)}};
  const auto shards = out.at("files").at("shards").get<std::size_t>();
  for (const int ranks : options.ranks) {
    const mpi::SimulatedRanks on{
        .ranks = ranks,
        .ranks_per_node = options.ranks_per_node > 0 ? options.ranks_per_node : ranks};
    const mpi::Schedule schedule =
        mpi::simulate(mpi::TaskBoard(work.tasks), work.times.seconds, on, costs.service);
    out["schedules"].push_back(describe(schedule, work, on, costs, shards));
  }
  return out;
}

}  // namespace carillon::cli
