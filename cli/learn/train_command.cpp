#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/build_options.hpp"
#include "cli/learning_commands.hpp"
#include "core/files.hpp"
#include "core/progress.hpp"
#include "dataset/run/run_builds.hpp"
#include "eval/scripts/run_script.hpp"
#include "eval/studies/learning/learning_config.hpp"
#include "eval/studies/learning/run_trainings.hpp"
#include "eval/studies/learning/search.hpp"
#include "mpi/comm.hpp"
#include "mpi/folder_lock.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

eval::studies::LearningConfig read_config(const dataset::run::BuildOptions& options,
                                          MPI_Comm world) {
  const std::string text = dataset::run::shared_text(options.config, world);
  eval::studies::LearningConfig config;
  mpi::agreed(world, [&] {
    core::ConfigNode root = core::ConfigNode::parse(text, options.config, options.overrides);
    config = eval::studies::read_train_section(root, options.config);
  });
  return config;
}

ordered_json lines_of(const eval::studies::TrainingsEnd& end) {
  ordered_json lines = ordered_json::array();
  for (const eval::studies::TrainedClassifier& trained : end.trained) {
    ordered_json line = to_json(trained.record);
    line["key"] = trained.job.key;
    line["folder"] = std::filesystem::absolute(trained.job.folder).string();
    line["was_there"] = trained.was_there;
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string percent(double fraction) {
  return std::isnan(fraction) ? "-" : fmt::format("{:.2f} %", 100 * fraction);
}

/// Balanced accuracies come first, and where no task's classes are unequally many, not at all.
void print(const eval::studies::TrainingsEnd& end) {
  const bool balances = std::any_of(
      end.trained.begin(), end.trained.end(), [](const eval::studies::TrainedClassifier& trained) {
        const eval::studies::TrainingRecord& record = trained.record;
        return percent(record.test_balanced_accuracy) != percent(record.test_accuracy);
      });
  const auto line = [&](const auto& key, const auto& train, const auto& test, const auto& classes,
                        const auto& numbers, const auto& epochs, const std::string& balanced,
                        const std::string& accuracy, const std::string& time) {
    fmt::print("{:44} {:>8} {:>8} {:>8} {:>10} {:>7}{} {:>10} {:>12}\n", key, train, test, classes,
               numbers, epochs, balances ? fmt::format(" {:>10}", balanced) : "", accuracy, time);
  };
  line("training", "train", "test", "classes", "numbers", "epochs", "balanced", "accuracy", "time");
  for (const eval::studies::TrainedClassifier& trained : end.trained) {
    const eval::studies::TrainingRecord& record = trained.record;
    const auto learnt = record.learnt.value_or(eval::studies::TrainingRecord::Learnt{});
    line(trained.job.key, record.train_samples, record.test_samples, record.classes.size(),
         learnt.parameters, learnt.best_epoch, percent(record.test_balanced_accuracy),
         percent(record.test_accuracy),
         trained.was_there ? "was there" : core::human_duration(record.seconds));
  }
}

/// Learning curves are drawn of what learns in epochs.
bool has_curves(const eval::studies::TrainedClassifier& trained) {
  return std::filesystem::exists(trained.job.folder / "curves.csv");
}

/// What is printed, then trainings.json and its picture beside the models.
void tell(const eval::studies::TrainingsEnd& end, const std::filesystem::path& models, bool json) {
  const ordered_json lines = lines_of(end);
  const ordered_json document = {
      {"output", models.string()}, {"trainings", lines}, {"interrupted", end.interrupted}};
  if (json) {
    fmt::print("{}\n", document.dump(1));
  } else if (!lines.empty()) {
    print(end);
    fmt::print("\n{}: of each model, curves.csv, answers.h5, training.json\n", models.string());
  }
  if (end.interrupted || lines.empty()) return;
  const std::filesystem::path path = models.parent_path() / "trainings.json";
  core::write_text_durably(path, document.dump(1) + "\n");
  for (const char* picture : {".svg", ".png"}) {  // of other trainings
    std::filesystem::remove(std::filesystem::path(path).replace_extension(picture));
  }
  if (std::none_of(end.trained.begin(), end.trained.end(), has_curves)) return;
  const std::string no_picture = eval::scripts::draw_picture("plot_trainings", path);
  if (!no_picture.empty()) {
    fmt::print(stderr, "carillon: {}\n", no_picture);
  } else if (!json) {
    fmt::print("{}, .svg, .png: learning curves\n", path.string());
  }
}

std::vector<eval::studies::Search> read_all_searches(const dataset::run::BuildOptions& options,
                                                     MPI_Comm world) {
  const std::string text = dataset::run::shared_text(options.config, world);
  std::vector<eval::studies::Search> searches;
  mpi::agreed(world, [&] { searches = eval::studies::read_searches(text, options); });
  return searches;
}

int search(const std::vector<eval::studies::Search>& searches,
           const eval::studies::LearningConfig& config,
           const eval::studies::EvaluatedDatasets& datasets, const Context& context) {
  const auto found = eval::studies::run_searches(searches, config, datasets, context.world);
  if (!found) return mpi::exit_interrupted;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    const std::filesystem::path path = datasets.output() / "evaluation" / "search.json";
    const ordered_json document = to_json(*found);
    core::write_text_durably(path, document.dump(1) + "\n");
    if (context.json) {
      fmt::print("{}\n", ordered_json{{"output", path.string()}, {"searches", document}}.dump(1));
    } else {
      fmt::print("{}{}\n", eval::studies::to_text(*found), path.string());
    }
  });
  return mpi::exit_done;
}

}  // namespace

int run_train(const TrainOptions& wanted, const Context& context) {
  dataset::run::BuildOptions options = with_common(wanted.build, context);
  if (context.json) options.tell = {};
  const std::vector<eval::studies::Search> searches =
      wanted.search ? read_all_searches(options, context.world)
                    : std::vector<eval::studies::Search>{};
  const eval::studies::LearningConfig config = read_config(options, context.world);
  const eval::studies::EvaluatedDatasets datasets(options, context.world);
  const int exit_code = datasets.build(context.world);
  if (exit_code == mpi::exit_interrupted) return exit_code;
  const mpi::FolderLock lock(datasets.output(), context.world, dataset::run::lock_timeout_s);
  const mpi::InterruptGuard guard;
  if (wanted.search) {
    const int code = search(searches, config, datasets, context);
    return code == mpi::exit_done ? exit_code : code;
  }
  const std::uint64_t seeds[] = {config.methods.front().learning.seed};
  const auto sources = eval::studies::open_learning_sources(config, datasets, context.world);
  const eval::studies::TrainingsEnd end = eval::studies::run_trainings(
      config, seeds, sources, eval::studies::models_folder(datasets), context.world);
  mpi::agreed(context.world, [&] {
    if (context.speaks()) tell(end, eval::studies::models_folder(datasets), context.json);
  });
  return end.interrupted ? mpi::exit_interrupted : exit_code;
}

}  // namespace carillon::cli
