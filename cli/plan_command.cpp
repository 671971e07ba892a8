#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "core/progress.hpp"
#include "dataset/run/build.hpp"
#include "dataset/run/schedule.hpp"
#include "dataset/sweep/run_sweep.hpp"

namespace carillon::cli {

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
    fmt::print(
        "simulations of all parts of the split share {}: too few instances to hold some out\n",
        fmt::join(plan.at("shared_between_parts").get<std::vector<std::string>>(), ", "));
  }
  const nlohmann::json& estimate = plan.at("estimate");
  fmt::print("about {} of one rank, {} of memory per rank, {} on disk before compression\n",
             core::human_duration(estimate.at("rank_seconds").get<double>()),
             core::human_bytes(estimate.at("memory_bytes_per_rank").get<double>()),
             core::human_bytes(estimate.at("disk_bytes").get<double>()));
}

}  // namespace

void add_plan(Program& program, mpi::Context& context) {
  Command& command =
      program.add("plan", "what a build would run, and why; runs nothing", Needs::ranks);
  auto options = std::make_shared<dataset::run::BuildOptions>();
  command.option("config", options->config, "YAML configuration").required();
  command.option("--set", options->overrides, "key=value instead of the configuration's")
      .one_value_each();
  auto schedule = std::make_shared<dataset::run::ScheduleOptions>();
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
    if (const auto sweep = dataset::sweep::load_sweep(*options, context.world)) {
      if (context.speaks()) dataset::sweep::tell_sweep_plan(*sweep, *schedule, context.json);
      return;
    }
    const dataset::run::LoadedBuild build = dataset::run::load_build(*options, context.world);
    if (!context.speaks()) return;
    nlohmann::json plan = dataset::run::describe_plan(build);
    if (!schedule->ranks.empty())
      plan["simulated"] = dataset::run::simulate_build(build, *schedule);
    if (context.json) {
      fmt::print("{}\n", plan.dump(2));
    } else {
      print_plan(plan);
      if (plan.contains("simulated"))
        fmt::print("{}", dataset::run::schedule_text(plan.at("simulated")));
    }
  });
}

}  // namespace carillon::cli
