#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cli/evaluate/datasets.hpp"
#include "cli/learn/learning_config.hpp"
#include "cli/learn/trainings.hpp"

namespace carillon::cli {

/// A classifier that was trained, now or by an earlier run.
struct TrainedClassifier {
  std::size_t condition = 0;  ///< of the datasets
  TrainingJob job;
  bool was_there = false;
  nlohmann::ordered_json found;  ///< training.json
};

/// The same on every rank.
struct TrainingsEnd {
  std::vector<TrainedClassifier> trained;  ///< by dataset, task, method, seed
  bool interrupted = false;
};

/// A dataset whose splits hold what they promise, or recordings.
/// @throws InputError, FileError  a split that leaks, no dataset; on every rank alike
/// @note Collective on the context's world.
std::unique_ptr<eval::SampleSource> open_source(const Condition& condition,
                                                const LearningConfig& config,
                                                const Context& context);

/// Every method on every task of every dataset, once for each seed (neighbours are the same for all
/// seeds: once). The datasets are built, and their splits are held against what is stored first.
/// @throws InputError, FileError  a split that leaks, a sense that a dataset lacks; on every rank
/// @note Collective on the context's world.
TrainingsEnd run_trainings(const LearningConfig& config, std::span<const std::uint64_t> seeds,
                           const EvaluatedDatasets& datasets, const Context& context);

}  // namespace carillon::cli
