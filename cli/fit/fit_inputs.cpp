#include "cli/fit/fit_inputs.hpp"

#include "eval/features/feature_table.hpp"

namespace carillon::cli {

FitSource fit_source_of_table(const std::string& path) {
  FitSource source{path, eval::read_feature_table(path), "", {}};
  if (source.features.empty()) source.nothing = "the table has no lines";
  return source;
}

std::vector<eval::Feature> joined_features(const std::vector<FitSource>& sources) {
  std::vector<eval::Feature> features;
  for (const FitSource& source : sources) {
    features.insert(features.end(), source.features.begin(), source.features.end());
  }
  return features;
}

}  // namespace carillon::cli
