#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "cli/build/run_builds.hpp"
#include "cli/evaluate/evaluation.hpp"
#include "core/error.hpp"
#include "mpi/comm.hpp"
#include "mpi/folder_lock.hpp"

namespace carillon::cli {

namespace {

constexpr EvaluationSection sections[] = {{"damping", read_damping_validation}};

/// What every section of the configuration asks for, in the order of the list.
std::vector<RunEvaluation> read_sections(const BuildOptions& options,
                                         const EvaluatedDatasets& datasets, MPI_Comm world) {
  const std::string text = shared_text(options.config, world);
  std::vector<RunEvaluation> asked;
  mpi::agreed(world, [&] {
    core::ConfigNode root = core::ConfigNode::parse(text, options.config, options.overrides);
    if (!root.has("evaluate")) {
      root.fail("evaluate", "says what is to be found out, and is missing",
                "for example evaluate: {damping: {}}; docs/damping-validation.md");
    }
    core::ConfigNode node = root.child("evaluate");
    for (const EvaluationSection& section : evaluation_sections()) {
      if (!node.has(section.name)) continue;
      core::ConfigNode own = node.child(section.name);
      asked.push_back(section.read(own, datasets));
    }
    node.finish();
    if (asked.empty()) root.fail("evaluate", "asks for nothing", "give it a section: damping: {}");
  });
  return asked;
}

/// @return the exit code, the same on every rank
int run_evaluate(BuildOptions options, const Context& context) {
  options.tell = !context.json;
  const EvaluatedDatasets datasets(options, context.world);
  const std::vector<RunEvaluation> asked = read_sections(options, datasets, context.world);
  int exit_code = datasets.build(context);
  if (exit_code == exit_interrupted) return exit_code;
  const mpi::FolderLock lock(datasets.output(), context.world, lock_patience_s);
  const std::filesystem::path folder = datasets.output() / "evaluation";
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw core::FileError(fmt::format("{}: {}", folder.string(), error.message()));
  });
  for (const RunEvaluation& run : asked) {
    const int code = run(folder, context);
    if (code == exit_interrupted) return code;
    if (code != exit_done) exit_code = code;
  }
  return exit_code;
}

}  // namespace

std::span<const EvaluationSection> evaluation_sections() {
  return sections;
}

void add_evaluate(CLI::App& program, Context& context) {
  CLI::App* command = program.add_subcommand(
      "evaluate",
      "datasets, and what can be learnt back from their sounds; carries on where an "
      "earlier run stopped");
  auto options = std::make_shared<BuildOptions>();
  command->add_option("config", options->config, "YAML configuration with a section `evaluate`")
      ->required();
  command->add_option("-o,--output", options->output,
                      "folder of datasets and findings (default: the configuration's name)");
  command
      ->add_option("--set", options->overrides,
                   "key=value instead of the configuration's, e.g. evaluate.damping.draws=10")
      ->allow_extra_args(false);
  command->add_flag("--retry-failed", options->retry_failed, "try failed tasks again");
  command->footer(
      "Examples:\n"
      "  mpirun -n 4 carillon evaluate configs/damping-validation.yaml\n"
      "  carillon evaluate configs/damping-validation.yaml --set strikes.per_object=20 \\\n"
      "    --set 'evaluate.damping.sounds=[1, 5, 20]' --output small\n"
      "What was found lies in OUTPUT/evaluation: docs/damping-validation.md.");
  command->callback([&context, options] { context.exit_code = run_evaluate(*options, context); });
}

}  // namespace carillon::cli
