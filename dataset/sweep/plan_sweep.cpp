#include <fmt/format.h>

#include <algorithm>

#include "core/progress.hpp"
#include "dataset/run/costs.hpp"
#include "dataset/run/schedule.hpp"
#include "dataset/sweep/detail/shared_work.hpp"
#include "dataset/sweep/detail/table.hpp"
#include "dataset/sweep/run_sweep.hpp"

namespace carillon::dataset::sweep {

using nlohmann::ordered_json;

namespace {

ordered_json variant_plan(const run::LoadedBuild& build) {
  const nlohmann::json plan = run::describe_plan(build);
  const nlohmann::json& estimate = plan.at("estimate");
  ordered_json effects = ordered_json::array();
  for (const auto& effect : plan.at("effects")) {
    if (effect.at("enabled").get<bool>()) effects.push_back(effect.at("name").get<std::string>());
  }
  ordered_json row;
  for (const char* name : {"shapes", "samples"}) row[name] = plan.at(name);
  for (const char* name : {"rank_seconds", "memory_bytes_per_rank", "disk_bytes"}) {
    row[name] = estimate.at(name);
  }
  row["effects"] = effects;
  return row;
}

ordered_json describe_sweep(const LoadedSweep& loaded) {
  std::vector<ordered_json> rows;
  double seconds = 0, memory = 0, disk = 0;
  std::size_t samples = 0;
  for (const run::LoadedBuild& build : loaded.builds) {
    rows.push_back(variant_plan(build));
    seconds += rows.back().at("rank_seconds").get<double>();
    memory = std::max(memory, rows.back().at("memory_bytes_per_rank").get<double>());
    disk += rows.back().at("disk_bytes").get<double>();
    samples += rows.back().at("samples").get<std::size_t>();
  }
  const SharingCounts counts = count_shared_work(loaded.builds);
  ordered_json plan = json_table(loaded.name, loaded.sweep, rows);
  plan["samples"] = samples;
  plan["shared"] = {
      {"bodies", counts.bodies}, {"meshes", counts.meshes}, {"solves", counts.solves}};
  plan["estimate"] = {{"rank_seconds", seconds - counts.seconds_saved},
                      {"rank_seconds_alone", seconds},
                      {"memory_bytes_per_rank", memory},
                      {"disk_bytes", disk}};
  return plan;
}

void print_sweep_plan(const ordered_json& plan) {
  fmt::print("{}: a sweep of {} variants ({}), {} samples\n\n", plan.at("name").get<std::string>(),
             plan.at("variants").size(), plan.at("mode").get<std::string>(),
             plan.at("samples").get<std::size_t>());
  for (const ordered_json& variant : plan.at("variants")) {
    fmt::print("  {}: {} samples of {} shapes, about {} alone\n",
               variant.at("variant").get<std::string>(), variant.at("samples").get<std::size_t>(),
               variant.at("shapes").get<std::size_t>(),
               core::human_duration(variant.at("rank_seconds").get<double>()));
    for (const auto& [key, value] : variant.at("values").items()) {
      fmt::print("      {} = {}\n", key, value.get<std::string>());
    }
  }
  const ordered_json& shared = plan.at("shared");
  const ordered_json& estimate = plan.at("estimate");
  fmt::print("\nshared: {} bodies have {} different meshes and {} different solves\n",
             shared.at("bodies").get<std::size_t>(), shared.at("meshes").get<std::size_t>(),
             shared.at("solves").get<std::size_t>());
  fmt::print(
      "about {} of one rank ({} if nothing were shared), {} of memory per rank, {} on disk before "
      "compression\n",
      core::human_duration(estimate.at("rank_seconds").get<double>()),
      core::human_duration(estimate.at("rank_seconds_alone").get<double>()),
      core::human_bytes(estimate.at("memory_bytes_per_rank").get<double>()),
      core::human_bytes(estimate.at("disk_bytes").get<double>()));
  fmt::print("effects and solver of one variant: plan with --set sweep= and --set of its values\n");
}

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

void tell_sweep_plan(const LoadedSweep& loaded, const run::ScheduleOptions& schedule,
                     bool as_json) {
  ordered_json plan = describe_sweep(loaded);
  nlohmann::json simulated;
  if (!schedule.ranks.empty()) {
    simulated = run::simulate_builds(loaded.builds, sweep_tasks(loaded), schedule);
    plan["simulated"] = simulated;
  }
  if (as_json) {
    fmt::print("{}\n", plan.dump(2));
    return;
  }
  print_sweep_plan(plan);
  if (!simulated.is_null()) fmt::print("{}", run::schedule_text(simulated));
}

}  // namespace carillon::dataset::sweep
