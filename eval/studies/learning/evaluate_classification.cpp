#include <fmt/format.h>

#include "core/files.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "eval/scripts/run_script.hpp"
#include "eval/studies/learning/detail/classification.hpp"
#include "eval/studies/learning/detail/published_accuracies.hpp"
#include "eval/studies/learning/sections.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/made_by.hpp"

namespace carillon::eval::studies {

using core::ConfigNode;
using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

/// `published: {TASK: SET}` of one dataset, `{TASK: {DATASET: SET}}` of several.
void read_published(ConfigNode& node, const EvaluatedDatasets& datasets, ClassificationSpec& spec) {
  ConfigNode tasks = node.child("published");
  for (const std::string& task : tasks.keys()) {
    const auto& known = spec.learning.tasks;
    if (std::none_of(known.begin(), known.end(),
                     [&](const learning::TaskSpec& one) { return one.name == task; })) {
      tasks.fail(task, fmt::format("train.tasks has no \"{}\"", task));
    }
    std::map<std::string, std::string>& sets = spec.published[task];
    const bool joined = spec.learning.join || spec.learning.with;
    if (joined || datasets.conditions().size() == 1) {
      if (tasks.is_mapping(task)) {
        tasks.fail(task, "names a set for each dataset, and there is one",
                   fmt::format("--set evaluate.classification.published.{}=SET", task));
      }
      sets[joined ? "joined" : datasets.conditions().front().name] =
          tasks.choice(task, published_sets());
      continue;
    }
    ConfigNode of_task = tasks.child(task);
    for (const Condition& condition : datasets.conditions()) {
      if (of_task.has(condition.name)) {
        sets[condition.name] = of_task.choice(condition.name, published_sets());
      }
    }
  }
}

/// Files and the picture.
/// @return why there is no picture; "" where there is one
std::string keep(const Classification& found, const fs::path& folder) {
  const fs::path path = folder / "classification.json";
  core::write_text_durably(path, to_json(found).dump(1) + "\n");
  core::write_text_durably(folder / "classification.csv", to_csv(found));
  core::write_text_durably(folder / "classification.md", to_text(found));
  return scripts::draw_picture("plot_classification", path);
}

EvaluationEnd run(const ClassificationSpec& spec, const EvaluatedDatasets& datasets,
                  const fs::path& folder, MPI_Comm world) {
  const double start = core::monotonic_seconds();
  const mpi::InterruptGuard guard;
  const auto sources = open_learning_sources(spec.learning, datasets, world);
  const TrainingsEnd trainings =
      run_trainings(spec.learning, spec.seeds, sources, models_folder(datasets), world);
  if (trainings.interrupted) return {mpi::exit_interrupted};
  EvaluationEnd end;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    const Classification found =
        find_classification(spec, datasets.name(), sources, trainings.trained);
    const std::string no_picture = keep(found, folder);
    ordered_json& document = end.document;
    document = to_json(found);
    std::size_t made = 0;
    for (const TrainedClassifier& one : trainings.trained) made += one.was_there ? 0 : 1;
    document["output"] = folder.string();
    document["trained"] = made;
    document["timing"] = {{"classification_s", core::monotonic_seconds() - start}};
    keep_evaluation_trace(folder / "classification-trace.json", made > 0,
                          {{"timing", document["timing"]}, {"tasks_run", {{"training", made}}}},
                          mpi::made_by(datasets.options().command, world));
    end.text = fmt::format(
        "{}\ntrained {} of {} classifiers in {}\n{}: classification.json, .csv, .md{}\n",
        to_text(found), made, trainings.trained.size(),
        core::human_duration(core::monotonic_seconds() - start), folder.string(),
        no_picture.empty() ? ", .svg, .png" : "");
    if (!no_picture.empty()) fmt::print(stderr, "carillon: {}\n", no_picture);
  });
  return end;
}

}  // namespace

RunEvaluation read_classification(ConfigNode& node, ConfigNode& root,
                                  const EvaluatedDatasets& datasets) {
  ClassificationSpec spec;
  spec.learning = read_train_section(root, datasets.config());
  spec.seeds = read_seeds(node, spec.learning);
  read_published(node, datasets, spec);
  return [spec, &datasets](const fs::path& folder, MPI_Comm world) {
    return run(spec, datasets, folder, world);
  };
}

}  // namespace carillon::eval::studies
