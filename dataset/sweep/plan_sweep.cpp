#include "dataset/sweep/plan_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/progress.hpp"
#include "dataset/run/costs.hpp"
#include "dataset/sweep/detail/shared_work.hpp"
#include "dataset/sweep/detail/table.hpp"
#include "mpi/comm.hpp"

namespace carillon::dataset::sweep {

using nlohmann::ordered_json;

namespace {

/// The tasks of all variants as one board takes them: what others have meshed or solved before is
/// read from the cache.
std::vector<mpi::Task> sweep_tasks(const LoadedSweep& loaded) {
  std::vector<run::BuildRun> runs;
  for (std::size_t v = 0; v < loaded.builds.size(); ++v) {
    runs.push_back({loaded.builds[v], {}, loaded.sweep.variants[v].folder + "/"});
  }
  run::CommonTasks common = run::common_tasks(runs);
  order_shared_work(runs, common);
  return std::move(common.tasks);
}

}  // namespace

SweepPlan plan_sweep(const LoadedSweep& loaded, const run::ScheduleOptions& schedule) {
  SweepPlan out{.shared = count_shared_work(loaded.builds)};
  for (const run::LoadedBuild& build : loaded.builds) {
    const run::PlanSummary& one = out.variants.emplace_back(run::summarise_plan(build));
    out.samples += one.samples;
    out.rank_seconds_alone += one.rank_seconds;
    out.memory_per_rank = std::max(out.memory_per_rank, one.memory_per_rank);
    out.disk_bytes += one.disk.total();
  }
  if (!schedule.ranks.empty()) {
    out.simulated = run::simulate_builds(loaded.builds, sweep_tasks(loaded), schedule);
  }
  return out;
}

ordered_json to_json(const SweepPlan& plan, const LoadedSweep& loaded) {
  std::vector<ordered_json> rows;
  for (const run::PlanSummary& one : plan.variants) {
    ordered_json effects = ordered_json::array();
    for (const scene::PlannedEffect& effect : one.effects) {
      if (effect.enabled) effects.push_back(effect.name);
    }
    rows.push_back({{"shapes", one.shapes},
                    {"samples", one.samples},
                    {"rank_seconds", one.rank_seconds},
                    {"memory_bytes_per_rank", one.memory_per_rank},
                    {"disk_bytes", one.disk.total()},
                    {"effects", effects}});
  }
  ordered_json document = json_table(loaded.name, loaded.sweep, rows);
  document["samples"] = plan.samples;
  document["shared"] = {{"objects", plan.shared.objects},
                        {"meshes", plan.shared.meshes},
                        {"solves", plan.shared.solves}};
  document["estimate"] = {{"rank_seconds", plan.rank_seconds()},
                          {"rank_seconds_alone", plan.rank_seconds_alone},
                          {"memory_bytes_per_rank", plan.memory_per_rank},
                          {"disk_bytes", plan.disk_bytes}};
  if (plan.simulated) document["simulated"] = run::to_json(*plan.simulated);
  return document;
}

std::string plan_text(const SweepPlan& plan, const LoadedSweep& loaded) {
  const Sweep& sweep = loaded.sweep;
  std::string text = fmt::format("{}: a sweep of {} variants ({}), {} samples\n\n", loaded.name,
                                 plan.variants.size(), sweep.mode, plan.samples);
  for (std::size_t v = 0; v < plan.variants.size(); ++v) {
    const run::PlanSummary& one = plan.variants[v];
    text += fmt::format("  {}: {} samples of {} shapes, about {} alone\n", sweep.variants[v].folder,
                        one.samples, one.shapes, core::human_duration(one.rank_seconds));
    for (std::size_t k = 0; k < sweep.keys.size(); ++k) {
      text += fmt::format("      {} = {}\n", sweep.keys[k], sweep.variants[v].values[k]);
    }
  }
  text += fmt::format("\nshared: {} objects have {} different meshes and {} different solves\n",
                      plan.shared.objects, plan.shared.meshes, plan.shared.solves);
  text += fmt::format(
      "about {} of one rank ({} if nothing were shared), {} of memory per rank, {} on "
      "disk\n",
      core::human_duration(plan.rank_seconds()), core::human_duration(plan.rank_seconds_alone),
      core::human_bytes(plan.memory_per_rank), core::human_bytes(plan.disk_bytes));
  text += "effects and solver of one variant: plan with --set sweep= and --set of its values\n";
  if (plan.simulated) text += run::simulation_text(*plan.simulated);
  return text;
}

PlanReport plan_configuration(const run::BuildOptions& options,
                              const run::ScheduleOptions& schedule, MPI_Comm comm) {
  if (const auto sweep = load_sweep(options, comm)) {
    if (mpi::rank(comm) != 0) return {};
    const SweepPlan plan = plan_sweep(*sweep, schedule);
    return {plan_text(plan, *sweep), to_json(plan, *sweep)};
  }
  const run::LoadedBuild build = run::load_build(options, comm);
  if (mpi::rank(comm) != 0) return {};
  const run::PlanSummary plan = run::summarise_plan(build);
  PlanReport report{run::plan_text(plan), run::to_json(plan)};
  if (!schedule.ranks.empty()) {
    const run::SimulatedBuild simulated = run::simulate_build(build, schedule);
    report.document["simulated"] = run::to_json(simulated);
    report.text += run::simulation_text(simulated);
  }
  return report;
}

}  // namespace carillon::dataset::sweep
