#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "eval/studies/learning/learning_config.hpp"
#include "eval/studies/learning/learning_sources.hpp"
#include "eval/studies/learning/trainings.hpp"

namespace carillon::eval::studies {

/// A classifier that was trained, now or by an earlier run.
struct TrainedClassifier {
  std::size_t source = 0;  ///< which it learnt from
  TrainingJob job;
  bool was_there = false;
  TrainingRecord record;
};

/// The same on every rank.
struct TrainingsEnd {
  std::vector<TrainedClassifier> trained;  ///< by source, task, method, seed
  bool interrupted = false;
};

/// Folder of all models of a configuration.
std::filesystem::path models_folder(const EvaluatedDatasets& datasets);

/// Every method on every task of every source, once for each seed (with_seeds()).
/// @throws InputError, FileError  a modality that a source lacks; on every rank
/// @note Collective on world.
TrainingsEnd run_trainings(const LearningConfig& config, std::span<const std::uint64_t> seeds,
                           std::span<const LearningSource> sources,
                           const std::filesystem::path& models, MPI_Comm world);

}  // namespace carillon::eval::studies
