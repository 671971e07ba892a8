#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "cli/build/build.hpp"
#include "cli/build/costs.hpp"
#include "cli/build/disk.hpp"
#include "cli/build/schedule.hpp"
#include "cli/build/solver_plan.hpp"
#include "cli/command_line.hpp"
#include "cli/motion/cast.hpp"
#include "cli/sound/scene.hpp"
#include "cli/sweep/run_sweep.hpp"
#include "core/progress.hpp"

namespace carillon::cli {

nlohmann::json describe_plan(const LoadedBuild& build) {
  nlohmann::json effects = describe_effects(build.config.scene, build.config.band.max_modes);
  for (nlohmann::json& effect : effects) {
    effect["seconds"] = effect.at("seconds_per_sound").get<double>() *
                            static_cast<double>(build.plan.samples.size()) +
                        effect.at("seconds_per_shape").get<double>() *
                            static_cast<double>(build.plan.shapes.size());
  }
  double seconds = 0, memory = 0;
  std::map<int, std::size_t> tasks_of_width;
  std::size_t modes_tasks = 0, samples_tasks = 0;
  for (const mpi::Task& task : board_tasks(build.plan, build.config)) {
    seconds += task.cost;
    memory = std::max(memory, task.memory / task.width + idle_rank_bytes);
    ++tasks_of_width[task.width];
  }
  for (const BuildTask& task : build.plan.tasks) {
    ++(task.kind == TaskKind::modes ? modes_tasks : samples_tasks);
  }
  nlohmann::json groups = nlohmann::json::array();
  for (const auto& [width, tasks] : tasks_of_width) {
    groups.push_back({{"ranks", width}, {"tasks", tasks}});
  }
  nlohmann::json shared = nlohmann::json::array();
  if (build.config.motion) {
    std::set<std::string> played;
    for (const CastBody& body : build.config.motion->bodies) played.insert(body.object);
    for (const std::string& object : played) {
      if (!held_out(build.config, build.plan, object)) shared.push_back(object);
    }
  }
  return {{"name", build.config.name},
          {"shared_between_parts", shared},
          {"shapes", build.plan.shapes.size()},
          {"samples", build.plan.samples.size()},
          {"tasks", {{"modes", modes_tasks}, {"samples", samples_tasks}}},
          {"groups", groups},
          {"solver", plan_solver(build.config)},
          {"effects", effects},
          {"estimate",
           {{"rank_seconds", seconds},
            {"memory_bytes_per_rank", memory},
            {"disk_bytes",
             sample_bytes(build.config) * static_cast<double>(build.plan.samples.size())}}}};
}

namespace {

void print_plan(const nlohmann::json& plan) {
  fmt::print("{}: {} samples of {} shapes in {} + {} tasks\n\n", plan.at("name").get<std::string>(),
             plan.at("samples").get<std::size_t>(), plan.at("shapes").get<std::size_t>(),
             plan.at("tasks").at("modes").get<std::size_t>(),
             plan.at("tasks").at("samples").get<std::size_t>());
  for (const nlohmann::json& entry : plan.at("solver")) {
    fmt::print("  {:<14} {:<16} {}\n", entry.at("name").get<std::string>(),
               entry.at("text").get<std::string>(), entry.at("reason").get<std::string>());
  }
  fmt::print("\n");
  fmt::print("  {:<16} {:<5} {:>9}  {}\n", "effect", "", "cost", "asked for by, or why not needed");
  for (const nlohmann::json& effect : plan.at("effects")) {
    const double seconds = effect.at("seconds").get<double>();
    fmt::print("  {:<16} {:<5} {:>9}  {}\n", effect.at("name").get<std::string>(),
               effect.at("enabled").get<bool>() ? "on" : "off",
               seconds > 0 ? core::human_duration(seconds) : "",
               effect.at("reason").get<std::string>());
  }
  fmt::print("\n");
  for (const nlohmann::json& group : plan.at("groups")) {
    if (group.at("ranks") == 1) continue;
    fmt::print(
        "{} tasks on groups of {} ranks (ranks.unknowns_per_rank), or of all where there are "
        "fewer\n",
        group.at("tasks").get<std::size_t>(), group.at("ranks").get<int>());
  }
  if (!plan.at("shared_between_parts").empty()) {
    fmt::print("takes of all parts of the split share {}: too few instances to hold some out\n",
               fmt::join(plan.at("shared_between_parts").get<std::vector<std::string>>(), ", "));
  }
  const nlohmann::json& estimate = plan.at("estimate");
  fmt::print("about {} of one rank, {} of memory per rank, {} on disk before compression\n",
             core::human_duration(estimate.at("rank_seconds").get<double>()),
             core::human_bytes(estimate.at("memory_bytes_per_rank").get<double>()),
             core::human_bytes(estimate.at("disk_bytes").get<double>()));
}

}  // namespace

void add_plan(Program& program, Context& context) {
  Command& command =
      program.add("plan", "what a build would run, and why; runs nothing", Needs::ranks);
  auto options = std::make_shared<BuildOptions>();
  command.option("config", options->config, "YAML configuration").required();
  command.option("--set", options->overrides, "key=value instead of the configuration's")
      .one_value_each();
  auto schedule = std::make_shared<ScheduleOptions>();
  Option ranks = command.option("--ranks", schedule->ranks,
                                "also simulate the schedule on so many ranks: 1,2,64,4096");
  ranks.delimiter(',').range(1, 10000000).one_value_each();
  command.option("--ranks-per-node", schedule->ranks_per_node, "ranks that share a memory")
      .range(1, 10000000)
      .needs(ranks);
  command
      .option("--trace", schedule->trace,
              "folder or trace.json of a dataset or sweep: its task times instead of "
              "estimates")
      .needs(ranks);
  command.footer(
      "Examples:\n  carillon plan configs/smoke.yaml\n"
      "  carillon plan configs/rsaudio.yaml --ranks 64,4096 --ranks-per-node 64 --trace rsaudio");
  command.does([&context, options, schedule] {
    if (const auto sweep = load_sweep(*options, context.world)) {
      if (context.speaks()) tell_sweep_plan(*sweep, *schedule, context.json);
      return;
    }
    const LoadedBuild build = load_build(*options, context.world);
    if (!context.speaks()) return;
    nlohmann::json plan = describe_plan(build);
    if (!schedule->ranks.empty()) plan["simulated"] = simulate_build(build, *schedule);
    if (context.json) {
      fmt::print("{}\n", plan.dump(2));
    } else {
      print_plan(plan);
      if (plan.contains("simulated")) fmt::print("{}", schedule_text(plan.at("simulated")));
    }
  });
}

}  // namespace carillon::cli
