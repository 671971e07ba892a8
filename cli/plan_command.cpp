#include "cli/build_options.hpp"
#include "cli/command_line.hpp"
#include "cli/context.hpp"
#include "dataset/run/plan_summary.hpp"
#include "dataset/run/schedule.hpp"
#include "dataset/sweep/plan_sweep.hpp"

namespace carillon::cli {

void add_plan(Program& program, Context& context) {
  Command& command =
      program.add("plan", "what a build would run, and why; runs nothing", Needs::ranks);
  auto options = std::make_shared<dataset::run::BuildOptions>();
  command.option("config", options->config, "YAML configuration; - reads it from standard input")
      .required();
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
    const dataset::run::BuildOptions all = with_standard_input(*options, context);
    if (const auto sweep = dataset::sweep::load_sweep(all, context.world)) {
      if (!context.speaks()) return;
      const dataset::sweep::SweepPlan plan = dataset::sweep::plan_sweep(*sweep, *schedule);
      teller(context)(dataset::sweep::plan_text(plan, *sweep),
                      dataset::sweep::to_json(plan, *sweep));
      return;
    }
    const dataset::run::LoadedBuild build = dataset::run::load_build(all, context.world);
    if (!context.speaks()) return;
    const dataset::run::PlanSummary plan = dataset::run::summarise_plan(build);
    nlohmann::json document = dataset::run::to_json(plan);
    std::string text = dataset::run::plan_text(plan);
    if (!schedule->ranks.empty()) {
      const dataset::run::SimulatedBuild simulated = dataset::run::simulate_build(build, *schedule);
      document["simulated"] = dataset::run::to_json(simulated);
      text += dataset::run::simulation_text(simulated);
    }
    teller(context)(text, document);
  });
}

}  // namespace carillon::cli
