#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "cli/build_options.hpp"
#include "cli/command_line.hpp"
#include "cli/learn_program.hpp"
#include "cli/learning_commands.hpp"
#include "core/error.hpp"
#include "dataset/run/run_builds.hpp"
#include "eval/studies/evaluation.hpp"
#include "mpi/comm.hpp"
#include "mpi/folder_lock.hpp"

namespace carillon::cli {

namespace {

using nlohmann::ordered_json;

using Sections = std::span<const eval::studies::EvaluationSection>;

struct AskedSection {
  const char* name;
  eval::studies::RunEvaluation run;
};

/// What every section of the configuration asks for, in the order of the list.
std::vector<AskedSection> read_sections(const dataset::run::BuildOptions& options,
                                        Sections sections,
                                        const eval::studies::EvaluatedDatasets& datasets,
                                        MPI_Comm world) {
  const std::string text = dataset::run::shared_text(options.config, world);
  std::vector<AskedSection> asked;
  mpi::agreed(world, [&] {
    core::ConfigNode root = core::ConfigNode::parse(text, options.config, options.overrides);
    if (!root.has("evaluate")) {
      root.fail("evaluate", "says what is to be found out, and is missing",
                "for example evaluate: {damping: {}} (docs/damping-validation.md) or "
                "{classification: {}} (docs/learning.md)");
    }
    core::ConfigNode node = root.child("evaluate");
    for (const eval::studies::EvaluationSection& section : sections) {
      if (!node.has(section.name)) continue;
      core::ConfigNode own = node.child(section.name);
      asked.push_back({section.name, section.read(own, root, datasets)});
    }
    node.finish();
    if (asked.empty())
      root.fail("evaluate", "asks for nothing",
                "give it a section: damping: {} or classification: {}");
  });
  return asked;
}

/// @return the exit code, the same on every rank
int run_evaluate(const dataset::run::BuildOptions& given, Sections sections,
                 const Context& context) {
  dataset::run::BuildOptions options = with_common(given, context);
  if (context.json) options.tell = {};
  const eval::studies::EvaluatedDatasets datasets(options, context.world);
  const std::vector<AskedSection> asked = read_sections(options, sections, datasets, context.world);
  int exit_code = datasets.build(context.world);
  if (exit_code == mpi::exit_interrupted) return exit_code;
  const mpi::FolderLock lock(datasets.output(), context.world, dataset::run::lock_timeout_s);
  const std::filesystem::path folder = datasets.output() / "evaluation";
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw core::FileError(fmt::format("{}: {}", folder.string(), error.message()));
  });
  ordered_json documents = ordered_json::object();
  for (const AskedSection& section : asked) {
    eval::studies::EvaluationEnd end = section.run(folder, context.world);
    if (!context.json) fmt::print("{}", end.text);
    const int code = end.exit_code;
    if (code == mpi::exit_interrupted) return code;
    documents[section.name] = std::move(end.document);
    if (code != mpi::exit_done) exit_code = code;
  }
  if (context.json && context.speaks()) {
    // One section's document stands for itself.
    fmt::print("{}\n", (asked.size() == 1 ? documents[asked[0].name] : documents).dump(1));
  }
  return exit_code;
}

/// Whether the configuration asks for a section that only carillon-learn has. What is wrong with it
/// is told when it is read on all ranks.
bool goes_elsewhere(const dataset::run::BuildOptions& options, Sections sections) {
  try {
    const std::string text = core::read_text_file(options.config);
    core::ConfigNode root = core::ConfigNode::parse(text, options.config, options.overrides);
    if (!root.has("evaluate")) return false;
    const core::ConfigNode node = root.child("evaluate");
    return std::any_of(sections.begin(), sections.end(),
                       [&](const eval::studies::EvaluationSection& section) {
                         return section.elsewhere && node.has(section.name);
                       });
  } catch (const core::Error&) {
    return false;
  }
}

}  // namespace

void add_evaluate(Program& program, Context& context, Sections sections) {
  Command& command =
      program.add("evaluate",
                  "datasets, and what can be learnt back from their sounds; carries on where an "
                  "earlier run stopped",
                  Needs::solver);
  auto options = std::make_shared<dataset::run::BuildOptions>();
  command.option("config", options->config, "YAML configuration with a section `evaluate`")
      .required();
  command.option("-o,--output", options->output,
                 "folder of datasets and findings (default: the configuration's name)");
  command
      .option("--set", options->overrides,
              "key=value instead of the configuration's, e.g. evaluate.damping.draws=10")
      .one_value_each();
  auto device = std::make_shared<std::string>();
  add_device(command, *device);
  command.flag("--retry-failed", options->retry_failed, "try failed tasks again");
  command.footer(
      "Examples:\n"
      "  mpirun -n 4 carillon evaluate configs/damping-validation.yaml\n"
      "  carillon evaluate configs/damping-validation.yaml --set strikes.per_object=20 \\\n"
      "    --set 'evaluate.damping.sound_counts=[1, 5, 20]' --output small\n"
      "  mpirun -n 2 carillon evaluate configs/learning-smoke.yaml\n"
      "What was found lies in OUTPUT/evaluation: docs/damping-validation.md, docs/learning.md.");
  command.begins_with([&context, options, sections] {
    if (goes_elsewhere(*options, sections)) become_learner(context.arguments);
  });
  command.does([&context, options, device, sections] {
    options->overrides = with_device(options->overrides, *device);
    context.exit_code = run_evaluate(*options, sections, context);
  });
}

}  // namespace carillon::cli
