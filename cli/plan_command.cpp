#include "cli/build_options.hpp"
#include "cli/command_line.hpp"
#include "cli/context.hpp"
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
    const dataset::sweep::PlanReport plan = dataset::sweep::plan_configuration(
        with_standard_input(*options, context), *schedule, context.world);
    if (context.speaks()) teller(context)(plan.text, plan.document);
  });
}

}  // namespace carillon::cli
