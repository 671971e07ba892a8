#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/progress.hpp"
#include "dataset/run/schedule.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

std::size_t count(const FileCounts& files) {
  return files.modes + files.shards + files.wav + files.png + files.others;
}

int nodes(const mpi::SimulatedRanks& on) {
  return (on.ranks - 1) / on.ranks_per_node + 1;
}

json to_json(const SimulatedSchedule& schedule) {
  const mpi::Schedule& went = schedule.went;
  const double span = went.makespan;
  return {{"ranks", schedule.on.ranks},
          {"nodes", nodes(schedule.on)},
          {"makespan_s", span},
          {"efficiency", went.efficiency},
          {"all_at_work_until_s", went.all_at_work_until},
          {"half_at_work_until_s", went.half_at_work_until},
          {"straggler_fraction", span > 0 ? 1 - went.all_at_work_until / span : 0},
          {"shared_work_s", went.shared_work},
          {"longest_chain_s", went.longest_chain},
          {"last_task", schedule.last_task},
          {"idle_s", went.idle},
          {"memory_wait_s", went.memory_wait},
          {"refused_tasks", went.refused},
          {"node_memory_bytes", went.node_memory},
          {"limited_by", schedule.limited_by}};
}

}  // namespace

json to_json(const SimulatedBuild& simulation) {
  const FileCounts& files = simulation.files;
  json out = {{"tasks",
               {{"count", simulation.tasks},
                {"measured", simulation.measured},
                {"ratio", simulation.ratio},
                {"longest", simulation.longest},
                {"longest_s", simulation.longest_s}}},
              {"files",
               {{"count", count(files)},
                {"modes", files.modes},
                {"shards", files.shards},
                {"wav", files.wav},
                {"png", files.png},
                {"shard_bytes", files.shard_bytes},
                {"largest_shard_bytes", files.largest_shard_bytes},
                {"largest_folder", files.largest_folder}}}};
  if (simulation.last_run) out["last_run"] = plan::to_json(*simulation.last_run);
  for (const SimulatedSchedule& one : simulation.schedules) {
    out["schedules"].push_back(to_json(one));
  }
  return out;
}

std::string simulation_text(const SimulatedBuild& simulation) {
  std::vector<std::string> ratios;
  for (const auto& [kind, value] : simulation.ratio) {
    ratios.push_back(fmt::format("{:.2f} times for {}", value, kind));
  }
  std::string text = fmt::format(
      "\nsimulated with {} of {} tasks' times measured, the others estimated ({})\nlongest task: "
      "{}, {}\n",
      simulation.measured, simulation.tasks, fmt::join(ratios, ", "), simulation.longest,
      core::human_duration(simulation.longest_s));
  if (simulation.last_run) {
    text += fmt::format("the trace's last run: {}", plan::run_text(*simulation.last_run));
  }
  const FileCounts& files = simulation.files;
  text += fmt::format(
      "{} files: {} of modes, {} shards of up to {}, {} WAV, {} PNG; up to {} in a folder\n\n",
      count(files), files.modes, files.shards, core::human_bytes(files.largest_shard_bytes),
      files.wav, files.png, files.largest_folder);
  text += fmt::format("{:>7} {:>6} {:>12} {:>8} {:>12} {:>12} {:>10}  {}\n", "ranks", "nodes",
                      "tasks", "effic.", "all work to", "half to", "node mem.", "limited by");
  for (const auto& [on, went, last_task, limited_by] : simulation.schedules) {
    text += fmt::format("{:>7} {:>6} {:>12} {:>6.1f} % {:>12} {:>12} {:>10}  {}\n", on.ranks,
                        nodes(on), core::human_duration(went.makespan), 100 * went.efficiency,
                        core::human_duration(went.all_at_work_until),
                        core::human_duration(went.half_at_work_until),
                        core::human_bytes(went.node_memory), limited_by);
  }
  for (const SimulatedSchedule& one : simulation.schedules) {
    if (one.went.refused == 0) continue;
    text += fmt::format(
        "on {} ranks {} of {} tasks are refused: no node has their memory "
        "(ranks.memory_per_node), or they wait for such\n",
        one.on.ranks, one.went.refused, simulation.tasks);
  }
  return text;
}

}  // namespace carillon::dataset::run
