#include "cli/fit/fit_inputs.hpp"

#include "core/error.hpp"
#include "eval/features/feature_table.hpp"
#include "eval/features/read_clip.hpp"

namespace carillon::cli {

FitSource fit_source_of_recording(const std::string& path, const eval::FeatureOptions& options) {
  FitSource source{path, {}, "", {}};
  try {
    eval::FeatureSet found = eval::read_features(path, options);
    source.features = std::move(found.features);
    source.remarks = std::move(found.remarks);
    if (source.features.empty()) {
      source.nothing = found.nothing.empty() ? "no decaying tone" : found.nothing;
    }
  } catch (const core::FileError& error) {
    source.nothing = error.message();
  } catch (const core::InputError& error) {
    source.nothing = error.message();
  }
  return source;
}

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
