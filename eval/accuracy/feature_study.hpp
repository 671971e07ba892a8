#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/config.hpp"

namespace carillon::eval::accuracy {

/// How near features of recordings come to the least error that noise allows, and how long they
/// take: clips of known modes.
struct FeatureStudy {
  std::vector<std::string> methods;  ///< `esprit`, `peaks`
  std::vector<int> modes;            ///< of a clip
  std::vector<double> snr_db;        ///< against the mean power of the first 100 ms
  int clips = 5;                     ///< of each combination
  double seconds = 1;                ///< of a clip
  double sample_rate = 44100;        ///< [Hz]
};

/// Reads `features:` of a study's configuration.
/// @throws ConfigError
FeatureStudy read_feature_study(core::ConfigNode node);

/// Runs it on this rank: frequencies spread evenly in pitch with random offsets from 200 Hz to
/// 14 kHz, decay rates of 3 to 30 1/s that rise with frequency, random amplitudes (within 10 dB)
/// and phases, white noise.
/// @return `clips`, `seconds` and `levels[]`: `method`, `modes`, `snr_db`, `seconds` (processor
/// time
///         of a clip, median), `found` (fraction of the modes), `extra` (features of a clip that
///         are no mode, mean), and `bounds_frequency`, `bounds_decay_rate`: median errors over the
///         Cramer-Rao bound, 1 for an efficient estimate
nlohmann::ordered_json measure_features(const FeatureStudy& study);

}  // namespace carillon::eval::accuracy
