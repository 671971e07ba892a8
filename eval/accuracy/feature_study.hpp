#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/config.hpp"

namespace carillon::eval::accuracy {

/// How near features of recordings come to the least error that noise allows, and how long they
/// take: clips of known modes.
struct FeatureStudy {
  std::vector<std::string> extractors;  ///< `esprit`, `peaks`
  std::vector<int> mode_counts;         ///< of a clip
  std::vector<double> snr_db;           ///< against the mean power of the first 100 ms
  int clips = 5;                        ///< of each combination
  double seconds = 1;                   ///< of a clip
  double sample_rate = 44100;           ///< [Hz]
};

/// Reads `features:` of a study's configuration.
/// @throws ConfigError
FeatureStudy read_feature_study(core::ConfigNode node);

/// What came of it.
struct FeatureFindings {
  std::string failure{};  ///< why there is nothing else, else ""
  int clips = 0;
  double seconds = 0;  ///< of a clip
  struct RefinementLevel {
    std::string method;
    int modes = 0;
    double snr_db = 0;
    double seconds = 0;  ///< processor time of a clip, median
    double found = 0;    ///< fraction of the modes
    double extra = 0;    ///< features of a clip that are no mode, mean
    /// Median errors over the Cramer-Rao bound, 1 for an efficient estimate; NaN where none is
    /// found.
    double bounds_frequency = 0, bounds_decay_rate = 0;
  };
  std::vector<RefinementLevel> levels{};
};

nlohmann::ordered_json to_json(const FeatureFindings& findings);
/// A table for a person.
void print(const FeatureFindings& findings);

/// Runs it on this rank: frequencies spread evenly in pitch with random offsets from 200 Hz to
/// 14 kHz, decay rates of 3 to 30 1/s that rise with frequency, random amplitudes (within 10 dB)
/// and phases, white noise.
FeatureFindings measure_features(const FeatureStudy& study);

}  // namespace carillon::eval::accuracy
