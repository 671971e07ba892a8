#include "cli/command_line.hpp"
#include "dataset/run/build.hpp"
#include "dataset/sweep/run_sweep.hpp"

namespace carillon::cli {

void add_build(Program& program, mpi::Context& context) {
  Command& command = program.add(
      "build", "the dataset of a configuration; carries on where an earlier run stopped",
      Needs::solver);
  auto options = std::make_shared<dataset::run::BuildOptions>();
  command.option("config", options->config, "YAML configuration").required();
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
    const auto sweep = dataset::sweep::load_sweep(*options, context.world);
    context.exit_code = sweep ? dataset::sweep::run_sweep(*sweep, *options, context)
                              : dataset::run::run_build(*options, context);
  });
}

}  // namespace carillon::cli
