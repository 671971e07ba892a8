#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "eval/scoring/seed_answers.hpp"
#include "eval/studies/learning/run_trainings.hpp"

namespace carillon::eval::studies {

/// What `evaluate.classification` asks for: the trainings of the section `train`, for several
/// seeds.
struct ClassificationSpec {
  LearningConfig learning;
  std::vector<std::uint64_t> seeds;
  /// Of a task and a dataset (its name): the published set that its accuracies stand beside.
  std::map<std::string, std::map<std::string, std::string>> published;
};

/// How the classifiers of one method did on one task of one dataset.
struct ClassificationRow {
  std::string dataset, task, method;
  std::string modalities;  ///< letters as the papers' tables have them
  std::vector<std::uint64_t> seeds;
  std::size_t samples = 0, groups = 0;  ///< held out
  std::vector<std::string> classes;
  std::optional<scoring::Estimate> accuracy, balanced_accuracy;
  classification::Confusion confusion;
  double validation_accuracy = core::nan;  ///< mean over seeds; NaN where one has none
  std::int64_t parameters = 0;             ///< that were learnt
  double training_s = 0;                   ///< mean over seeds
  /// Of a network that only hears: errors of calibration, areas and shares, means over seeds; of
  /// an area's intervals the lowest and the highest end.
  std::optional<recognition::RecognitionTrial> recognition;
  struct Published {
    std::string set;
    double accuracy = 0;
  };
  std::optional<Published> published;
  bool chosen = false;  ///< best on the validation samples, which alone may choose
  std::optional<scoring::Estimate> difference{};  ///< from the chosen one, on the same samples
  std::string difference_from{};                  ///< the chosen one's method
};

/// What `evaluate.classification` found.
struct Classification {
  std::string name;
  std::vector<learning::TaskSpec> tasks;
  struct Dataset {
    std::string name, folder;
  };
  std::vector<Dataset> datasets;
  std::vector<ClassificationRow> rows;
};

/// Accuracies of every method on every task of every source, from what the classifiers answered
/// for the samples that were held out.
///
/// Intervals are over the objects that are held out where whole objects are (`split_shape`), else
/// over strikes; with several seeds over these, too.
/// @throws FileError   answers that cannot be read
///         InputError  a task's classifiers answered for different samples
Classification find_classification(const ClassificationSpec& spec, const std::string& name,
                                   std::span<const LearningSource> sources,
                                   const std::vector<TrainedClassifier>& trained);

/// docs/learning.md names the fields.
nlohmann::ordered_json to_json(const Classification& found);
/// For people, in Markdown: a table of each task and dataset, the best method's recalls and
/// confusions, and what differs from the papers' sets where their numbers stand beside.
std::string to_text(const Classification& found);
/// One row for each method, task and dataset.
std::string to_csv(const Classification& found);

}  // namespace carillon::eval::studies
