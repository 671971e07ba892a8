#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

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

/// Accuracies of every method on every task of every source, from what the classifiers answered
/// for the samples that were held out; docs/learning.md names the fields.
///
/// Intervals are over the bodies that are held out where whole bodies are (`split_shape`), else
/// over strikes; with several seeds over these, too.
/// @throws FileError   answers that cannot be read
///         InputError  a task's classifiers answered for different samples
nlohmann::ordered_json classification_document(const ClassificationSpec& spec,
                                               const std::string& name,
                                               std::span<const LearningSource> sources,
                                               const std::vector<TrainedClassifier>& trained);

}  // namespace carillon::eval::studies
