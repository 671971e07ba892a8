#include "cli/build_options.hpp"
#include "cli/command_line.hpp"
#include "dataset/run/build.hpp"
#include "dataset/sweep/run_sweep.hpp"

namespace carillon::cli {

void add_build(Program& program, Context& context) {
  Command& command = program.add(
      "build", "the dataset of a configuration; carries on where an earlier run stopped",
      Needs::solver);
  auto options = std::make_shared<dataset::run::BuildOptions>();
  command.option("config", options->config, "YAML configuration; - reads it from standard input")
      .required();
  command.option("-o,--output", options->output,
                 "folder of the dataset (default: the configuration's name)");
  command
      .option("--set", options->overrides,
              "key=value instead of the configuration's, e.g. audio.seconds=2")
      .one_value_each();
  command.flag("--retry-failed", options->retry_failed, "try failed tasks again");
  command.footer(
      "Examples:\n"
      "  mpirun -n 4 carillon build configs/smoke.yaml\n"
      "  carillon build configs/smoke.yaml --set strikes.per_object=1 --output small\n"
      "  mpirun -n 4 carillon build configs/sweep-damping.yaml    every variant of its `sweep`, "
      "and "
      "a table");
  command.does([&context, options] {
    const dataset::run::BuildOptions all =
        with_standard_input(with_common(*options, context), context);
    const auto sweep = dataset::sweep::load_sweep(all, context.world);
    const auto note_output = [&](const std::string& name) {
      context.on_finish.note_output(all.output.empty() ? name : all.output);
    };
    if (sweep) {
      note_output(sweep->name);
      context.exit_code = dataset::sweep::run_sweep(*sweep, all, context.world);
    } else {
      dataset::run::LoadedBuild build = dataset::run::load_build(all, context.world);
      note_output(build.config.name);
      context.exit_code = dataset::run::run_build(std::move(build), all, context.world);
    }
  });
}

}  // namespace carillon::cli
