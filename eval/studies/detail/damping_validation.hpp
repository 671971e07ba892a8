#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "eval/damping/fit_damping.hpp"
#include "eval/features/extract_features.hpp"
#include "eval/studies/evaluation.hpp"

namespace carillon::eval::studies {

/// The extractor that knows how a room decays (reverberant_modes()); without a room it is esprit.
inline constexpr const char* room_likelihood = "room_likelihood";

/// Where the features come from that damping is fitted to.
struct FeatureSource {
  std::string name;  ///< esprit, peaks, room_likelihood, or truth: the modes as they were computed
  bool truth = false;
  features::FeatureOptions options;
};

/// A material whose damping is sought, and known.
struct TrueMaterial {
  std::string name;
  std::vector<double> parameters;  ///< alpha1, alpha2, ...
};

struct NamedEstimator {
  std::string name;
  damping::Estimator estimator = damping::Estimator::emg;
};

/// What `evaluate.damping` asks for (Sterling 2019, section 5.3).
struct DampingValidation {
  std::string model;
  damping::DampingLaw law;
  std::vector<NamedEstimator> estimators;
  std::vector<std::size_t> sounds;  ///< that one fit is made from, ascending
  int draws = 30;                   ///< sets of sounds for each number of them
  std::vector<std::string>
      from;  ///< object: sounds of one object at a time; material: of any object
  std::uint64_t seed = 0;
  std::vector<FeatureSource> sources;
  bool keep_reverberant = false;  ///< features that may be the room's are fitted, too
  std::vector<std::vector<TrueMaterial>> materials;  ///< by condition
};

/// @throws ConfigError  also where the datasets' materials have no such damping, or objects have
///                      too few sounds
DampingValidation read_damping_config(core::ConfigNode& node, const EvaluatedDatasets& datasets);

}  // namespace carillon::eval::studies
