#include <fmt/format.h>

#include <memory>

#include "cli/command_line.hpp"
#include "cli/context.hpp"
#include "core/config.hpp"
#include "core/error.hpp"
#include "eval/accuracy/accuracy.hpp"
#include "eval/scripts/run_script.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

namespace {

/// @return the exit code, the same on every rank
int run_accuracy(eval::accuracy::AccuracyOptions options, const Context& context) {
  options.cache = context.cache;
  options.command = context.command;
  std::string text;
  mpi::agreed(context.world, [&] {
    if (context.speaks()) text = core::read_text_file(options.config);
  });
  text = mpi::broadcast(text, 0, context.world);
  eval::accuracy::AccuracyConfig config;
  mpi::agreed(context.world, [&] {
    config = eval::accuracy::read_accuracy_config(text, options.config, options.overrides);
  });

  const std::filesystem::path output = options.output.empty() ? config.name : options.output;
  require_output_folder(context, output.string());
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    std::error_code error;
    std::filesystem::create_directories(output, error);
    if (error) throw core::FileError(fmt::format("{}: {}", output.string(), error.message()));
  });
  const eval::accuracy::StudyFindings findings =
      eval::accuracy::measure_accuracy(config, output, options, context.world);
  const bool failed =
      mpi::broadcast(has_failed(findings) ? "failed" : "", 0, context.world) == "failed";
  const int exit_code = failed ? mpi::exit_failures : mpi::exit_done;
  if (!context.speaks()) return exit_code;

  const std::string no_picture =
      eval::scripts::draw_picture("plot_accuracy", output / "accuracy.json");
  if (context.json) {
    fmt::print("{}\n", findings.document.dump(1));
  } else {
    print(findings);
    fmt::print("\n{}: accuracy.json{}\n", output.string(),
               no_picture.empty() ? ", accuracy.svg, accuracy.png" : "");
  }
  if (!no_picture.empty()) fmt::print(stderr, "carillon: {}\n", no_picture);
  return exit_code;
}

}  // namespace

void add_accuracy(Program& program, Context& context) {
  Command& command =
      program.add("accuracy", "the convergence study: seconds against pitch errors", Needs::solver);
  auto options = std::make_shared<eval::accuracy::AccuracyOptions>();
  command.option("config", options->config, "YAML configuration").required();
  command.option("-o,--output", options->output,
                 "folder of the findings (default: the configuration's name)");
  command
      .option("--set", options->overrides,
              "key=value instead of the configuration's, e.g. modes=60")
      .one_value_each();
  command.footer(
      "Examples:\n"
      "  carillon accuracy configs/accuracy.yaml\n"
      "  carillon accuracy configs/accuracy.yaml --set objects[6].mesh=scan.ply -o study\n"
      "Exit code 3: an object or a target could not be measured; the others are in accuracy.json.");
  command.does([&context, options] { context.exit_code = run_accuracy(*options, context); });
}

}  // namespace carillon::cli
