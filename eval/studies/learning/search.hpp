#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dataset/run/build.hpp"
#include "dataset/sweep/sweep.hpp"
#include "eval/statistics/parzen_estimator.hpp"
#include "eval/studies/datasets.hpp"
#include "eval/studies/learning/learning_config.hpp"
#include "eval/studies/learning/training_record.hpp"

namespace carillon::eval::studies {

/// One method with values of its keys that are tried.
struct SearchTrial {
  std::vector<std::string> values;  ///< of the search's keys
  learning::Method method;
};

/// Trials of which the outcomes of others say what they are (`mode: parzen`).
struct SequentialTrials {
  std::size_t count = 0;
  std::uint64_t seed = 0;
  std::vector<statistics::ParzenAxis> axes;
  std::function<SearchTrial(const statistics::ParzenPoint&)> trial_at;
};

/// `search.METHOD` of a configuration: layer sizes and learning rates, as a sweep writes them.
struct Search {
  std::string method;
  learning::TaskSpec task;
  std::vector<std::string> keys;  ///< of the method
  std::vector<SearchTrial> trials;
  std::optional<SequentialTrials> sequential{};  ///< in place of `trials`
};

/// Every search of a configuration, in the order of the file.
/// @throws ConfigError  none, an unknown task or key, a value that the method refuses
std::vector<Search> read_searches(const std::string& text,
                                  const dataset::run::BuildOptions& options);

/// What a search found.
struct SearchFindings {
  std::string method, task, dataset;
  std::vector<std::string> keys;
  struct Trial {
    std::vector<std::string> values;  ///< of the keys
    TrainingRecord record;
    bool was_there = false;
  };
  std::vector<Trial> trials;  ///< the best first
};

/// Tries everything on the first of the datasets, and orders it by what was reached on the
/// validation samples alone: accuracy, then loss. What was tried before is not tried again.
/// @return of each search; nothing where it was interrupted
/// @note Collective on world.
std::optional<std::vector<SearchFindings>> run_searches(const std::vector<Search>& searches,
                                                        const LearningConfig& config,
                                                        const EvaluatedDatasets& datasets,
                                                        MPI_Comm world);

nlohmann::ordered_json to_json(const std::vector<SearchFindings>& searches);

/// For people: the best trials of each search, and the line of `train.methods` that records the
/// best.
std::string to_text(const std::vector<SearchFindings>& searches);

}  // namespace carillon::eval::studies
