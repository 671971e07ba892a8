#pragma once

#include <span>

#include "eval/features/extract_features.hpp"

namespace carillon::eval::features {

/// What of a recording is analysed.
struct SoundPart {
  std::span<const double> samples;
  double after_onset = 0;         ///< samples between the onset and the first of these
  double unheard = 0;             ///< of them, those in which the object was driven or clipped
  std::span<const double> quiet;  ///< before the first strike
};

/// Frequency that is looked at, of the sample rate.
inline constexpr double highest_frequency = 0.475;

/// Adds modes, hums and remarks of a sound to a set: its damped sinusoids by find_tones(), less
/// those that judge() finds to be no modes, indistinct() ones, and those that have lost 20 dB
/// before the object rings by itself.
void features_by_tones(const SoundPart& part, double sample_rate, const FeatureOptions& options,
                       FeatureSet& set);

}  // namespace carillon::eval::features
