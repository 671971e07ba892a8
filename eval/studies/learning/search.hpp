#pragma once

#include <string>
#include <vector>

#include "dataset/run/build.hpp"
#include "dataset/sweep/sweep.hpp"
#include "eval/studies/datasets.hpp"
#include "eval/studies/learning/learning_config.hpp"

namespace carillon::eval::studies {

/// One method with values of its keys that are tried.
struct SearchTrial {
  std::vector<std::string> values;  ///< of the search's keys
  learning::Method method;
};

/// `search.METHOD` of a configuration: layer sizes and learning rates, as a sweep writes them.
struct Search {
  learning::TaskSpec task;
  std::vector<std::string> keys;  ///< of the method
  std::vector<SearchTrial> trials;
};

/// Every search of a configuration, in the order of the file.
/// @throws ConfigError  none, an unknown task or key, a value that the method refuses
std::vector<Search> read_searches(const std::string& text,
                                  const dataset::run::BuildOptions& options);

/// Tries everything on the first of the datasets, and orders it by what was reached on the
/// validation samples alone: accuracy, then loss. What was tried before is not tried again.
/// @return document of all searches, the best trial of each first; null where it was interrupted
/// @note Collective on the context's world.
nlohmann::ordered_json run_searches(const std::vector<Search>& searches,
                                    const LearningConfig& config, const EvaluatedDatasets& datasets,
                                    const mpi::Context& context);

/// For people: the best trials of each search, and the line of `train.methods` that records the
/// best.
std::string search_text(const nlohmann::ordered_json& document);

}  // namespace carillon::eval::studies
