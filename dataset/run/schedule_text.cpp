#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/progress.hpp"
#include "dataset/plan/task_times.hpp"
#include "dataset/run/schedule.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

double number(const json& object, const char* key) {
  return object.at(key).get<double>();
}

std::string line_of(const json& one) {
  return fmt::format(
      "{:>7} {:>6} {:>12} {:>6.1f} % {:>12} {:>12} {:>10}  {}\n", one.at("ranks").get<int>(),
      one.at("nodes").get<int>(), core::human_duration(number(one, "makespan_s")),
      100 * number(one, "efficiency"), core::human_duration(number(one, "all_at_work_until_s")),
      core::human_duration(number(one, "half_at_work_until_s")),
      core::human_bytes(number(one, "node_memory_bytes")), one.at("limited_by").get<std::string>());
}

std::string refused_text(const json& one, std::size_t tasks) {
  const auto refused = one.at("refused_tasks").get<std::size_t>();
  if (refused == 0) return "";
  return fmt::format(
      "on {} ranks {} of {} tasks are refused: no node has their memory (ranks.memory_per_node), "
      "or "
      "they wait for such\n",
      one.at("ranks").get<int>(), refused, tasks);
}

/// Measured over estimated, kind by kind.
std::string ratio_text(const json& ratio) {
  std::vector<std::string> parts;
  for (const auto& [kind, value] : ratio.items()) {
    parts.push_back(fmt::format("{:.2f} times for {}", value.get<double>(), kind));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace

std::string schedule_text(const json& simulated) {
  const json& tasks = simulated.at("tasks");
  const json& files = simulated.at("files");
  std::string text = fmt::format(
      "\nsimulated with {} of {} tasks' times measured, the others estimated ({})\nlongest task: "
      "{}, "
      "{}\n",
      tasks.at("measured").get<std::size_t>(), tasks.at("count").get<std::size_t>(),
      ratio_text(tasks.at("ratio")), tasks.at("longest").get<std::string>(),
      core::human_duration(number(tasks, "longest_s")));
  if (simulated.contains("last_run")) {
    text += fmt::format("the trace's last run: {}", plan::run_text(simulated.at("last_run")));
  }
  text += fmt::format(
      "{} files: {} of modes, {} shards of up to {}, {} WAV, {} PNG; up to {} in a "
      "folder\n\n",
      files.at("count").get<std::size_t>(), files.at("modes").get<std::size_t>(),
      files.at("shards").get<std::size_t>(),
      core::human_bytes(number(files, "largest_shard_bytes")), files.at("wav").get<std::size_t>(),
      files.at("png").get<std::size_t>(), files.at("largest_folder").get<std::size_t>());
  text += fmt::format("{:>7} {:>6} {:>12} {:>8} {:>12} {:>12} {:>10}  {}\n", "ranks", "nodes",
                      "tasks", "effic.", "all work to", "half to", "node mem.", "limited by");
  for (const json& one : simulated.at("schedules")) text += line_of(one);
  for (const json& one : simulated.at("schedules")) text += refused_text(one, tasks.at("count"));
  return text;
}

}  // namespace carillon::dataset::run
