#include "dataset/run/plan_summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/progress.hpp"
#include "dataset/run/costs.hpp"
#include "dataset/samples/cast.hpp"

namespace carillon::dataset::run {

using nlohmann::json;

namespace {

/// Estimated seconds of an effect in the whole build.
double seconds_of(const scene::PlannedEffect& effect, const PlanSummary& plan) {
  return effect.seconds_per_sound * static_cast<double>(plan.samples) +
         effect.seconds_per_shape * static_cast<double>(plan.shapes);
}

}  // namespace

PlanSummary summarise_plan(const LoadedBuild& build) {
  PlanSummary out{.name = build.config.name,
                  .shapes = build.plan.shapes.size(),
                  .samples = build.plan.samples.size(),
                  .solver = plan::plan_solver(build.config, build.plan),
                  .effects = scene::plan_effects(build.config.scene, build.config.band.max_modes)};
  for (const mpi::Task& task : board_tasks(build.plan, build.config)) {
    out.rank_seconds += task.cost;
    out.memory_per_rank = std::max(out.memory_per_rank, task.memory / task.width + idle_rank_bytes);
    ++out.tasks_of_width[task.width];
  }
  for (const plan::BuildTask& task : build.plan.tasks) {
    ++(task.kind == plan::TaskKind::modes ? out.modes_tasks : out.samples_tasks);
  }
  out.disk = expected_bytes(build);
  if (build.config.motion) {
    std::set<std::string> played;
    for (const scene::motion::CastBody& body : build.config.motion->bodies)
      played.insert(body.object);
    for (const std::string& object : played) {
      if (!samples::held_out(build.config, build.plan, object))
        out.shared_between_parts.push_back(object);
    }
  }
  return out;
}

json to_json(const PlanSummary& plan) {
  json effects = json::array(), solver = json::array(), groups = json::array();
  for (const scene::PlannedEffect& effect : plan.effects) {
    effects.push_back(scene::to_json(effect));
    effects.back()["seconds"] = seconds_of(effect, plan);
  }
  for (const plan::SolverChoice& choice : plan.solver) {
    solver.push_back({{"name", choice.name},
                      {"value", choice.value},
                      {"text", choice.text},
                      {"reason", choice.reason}});
  }
  for (const auto& [width, tasks] : plan.tasks_of_width) {
    groups.push_back({{"ranks", width}, {"tasks", tasks}});
  }
  return {{"name", plan.name},
          {"shared_between_parts", plan.shared_between_parts},
          {"shapes", plan.shapes},
          {"samples", plan.samples},
          {"tasks", {{"modes", plan.modes_tasks}, {"samples", plan.samples_tasks}}},
          {"groups", groups},
          {"solver", solver},
          {"effects", effects},
          {"estimate",
           {{"rank_seconds", plan.rank_seconds},
            {"memory_bytes_per_rank", plan.memory_per_rank},
            {"disk_bytes", plan.disk.total()},
            {"disk", to_json(plan.disk)}}}};
}

std::string plan_text(const PlanSummary& plan) {
  std::string text = fmt::format("{}: {} samples of {} shapes in {} + {} tasks\n\n", plan.name,
                                 plan.samples, plan.shapes, plan.modes_tasks, plan.samples_tasks);
  for (const plan::SolverChoice& choice : plan.solver) {
    text += fmt::format("  {:<14} {:<16} {}\n", choice.name, choice.text, choice.reason);
  }
  text += fmt::format("\n  {:<16} {:<5} {:>9}  {}\n", "effect", "", "cost",
                      "asked for by, or why not needed");
  for (const scene::PlannedEffect& effect : plan.effects) {
    const double seconds = seconds_of(effect, plan);
    text += fmt::format("  {:<16} {:<5} {:>9}  {}\n", effect.name, effect.enabled ? "on" : "off",
                        seconds > 0 ? core::human_duration(seconds) : "", effect.reason);
  }
  text += "\n";
  for (const auto& [width, tasks] : plan.tasks_of_width) {
    if (width == 1) continue;
    text += fmt::format(
        "{} tasks on groups of {} ranks (ranks.unknowns_per_rank), or of all where there are "
        "fewer\n",
        tasks, width);
  }
  if (!plan.shared_between_parts.empty()) {
    text += fmt::format(
        "simulations of all parts of the split share {}: too few instances to hold some out\n",
        fmt::join(plan.shared_between_parts, ", "));
  }
  return text + fmt::format("about {} of one rank, {} of memory per rank, {} on disk: {}\n",
                            core::human_duration(plan.rank_seconds),
                            core::human_bytes(plan.memory_per_rank),
                            core::human_bytes(plan.disk.total()), bytes_text(plan.disk));
}

}  // namespace carillon::dataset::run
