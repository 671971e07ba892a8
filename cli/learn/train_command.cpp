#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <set>

#include "cli/build/run_builds.hpp"
#include "cli/learn/commands.hpp"
#include "cli/learn/learning_config.hpp"
#include "cli/learn/learning_data.hpp"
#include "cli/learn/trainings.hpp"
#include "core/progress.hpp"
#include "eval/learning/dataset_source.hpp"
#include "mpi/comm.hpp"
#include "mpi/folder_lock.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

LearningConfig read_config(const BuildOptions& options, MPI_Comm world) {
  const std::string text = shared_text(options.config, world);
  LearningConfig config;
  mpi::agreed(world, [&] {
    core::ConfigNode root = core::ConfigNode::parse(text, options.config, options.overrides);
    if (!root.has("train")) {
      root.fail(
          "train", "says what is learnt by what, and is missing",
          "for example train: {tasks: {material: {column: material}}, methods: {isnn-a: {}}}; "
          "docs/learning.md");
    }
    core::ConfigNode node = root.child("train");
    config = read_learning(node);
    node.finish();
  });
  return config;
}

/// Every method on every task of one source.
/// @return whether it was interrupted
bool train_source(const LearningData::Named& named, const LearningConfig& config,
                  const std::filesystem::path& models, ordered_json& found,
                  const Context& context) {
  std::unique_ptr<eval::SampleSource> source;
  mpi::agreed(context.world, [&] {
    std::set<std::string> splits;
    for (const eval::TaskSpec& task : config.tasks) splits.insert(task.split);
    if (context.speaks()) {
      for (const std::string& split : splits) require_clean_split(named.folder, split);
    }
  });
  mpi::agreed(context.world,
              [&] { source = eval::open_dataset_source(named.folder, config.listener); });
  for (const eval::TaskSpec& task : config.tasks) {
    for (const eval::Method& method : config.methods) {
      TrainingJob job = make_job(*source, task, method, models / named.name);
      if (!named.name.empty()) job.key = named.name + "/" + job.key;
      const JobEnd end = run_job(job, *source, context);
      if (end.interrupted) return true;
      ordered_json line = end.found;
      line["folder"] = job.folder.string();
      line["was_there"] = end.was_there;
      found.push_back(line);
    }
  }
  return false;
}

void print(const ordered_json& found) {
  fmt::print("{:44} {:>8} {:>8} {:>8} {:>10} {:>7} {:>10} {:>12}\n", "training", "train", "test",
             "classes", "numbers", "epochs", "accuracy", "time");
  for (const ordered_json& line : found) {
    const auto& accuracy = line.at("test_accuracy");
    fmt::print("{:44} {:>8} {:>8} {:>8} {:>10} {:>7} {:>10} {:>12}\n",
               line.at("key").get<std::string>(), line.at("samples").at("train").get<int>(),
               line.at("samples").at("test").get<int>(), line.at("classes").size(),
               line.value("parameters", 0), line.value("best_epoch", 0),
               accuracy.is_null() ? "-" : fmt::format("{:.2f} %", 100 * accuracy.get<double>()),
               line.at("was_there").get<bool>()
                   ? "was there"
                   : core::human_duration(line.at("timing").at("seconds").get<double>()));
  }
}

int run_train(BuildOptions options, const Context& context) {
  options.tell = !context.json;
  const LearningConfig config = read_config(options, context.world);
  const LearningData data(options, context.world);
  const int exit_code = data.build(context);
  if (exit_code == exit_interrupted) return exit_code;
  const mpi::FolderLock lock(data.output(), context.world, lock_patience_s);
  const mpi::InterruptGuard guard;
  const std::filesystem::path models = data.output() / "evaluation" / "models";
  ordered_json found = ordered_json::array();
  bool interrupted = false;
  for (const LearningData::Named& named : data.sources()) {
    interrupted = train_source(named, config, models, found, context);
    if (interrupted) break;
  }
  if (context.speaks()) {
    if (context.json) {
      fmt::print("{}\n", ordered_json{{"output", models.string()},
                                      {"trainings", found},
                                      {"interrupted", interrupted}}
                             .dump(1));
    } else if (!found.empty()) {
      print(found);
      fmt::print("\n{}: of each model, curves.csv, answers.h5, training.json\n", models.string());
    }
  }
  return interrupted ? exit_interrupted : exit_code;
}

}  // namespace

void add_train(CLI::App& program, Context& context) {
  CLI::App* command = program.add_subcommand("train", train_summary);
  auto options = std::make_shared<BuildOptions>();
  command->add_option("config", options->config, "YAML configuration with a section `train`")
      ->required();
  command->add_option(
      "-o,--output", options->output,
      "folder of the dataset and what is learnt (default: the configuration's name)");
  command
      ->add_option("--set", options->overrides,
                   "key=value instead of the configuration's, e.g. train.epochs=5")
      ->allow_extra_args(false);
  command->footer(
      "Examples:\n"
      "  mpirun -n 2 carillon train configs/learning-smoke.yaml\n"
      "  carillon train mine.yaml --set data=path/to/dataset --set train.seed=2\n"
      "Ranks share each step's samples; one thread a rank. docs/learning.md.");
  command->callback([&context, options] { context.exit_code = run_train(*options, context); });
}

}  // namespace carillon::cli
