#pragma once

#include <string>
#include <vector>

#include "eval/features/extract_features.hpp"

namespace carillon::eval::features {

constexpr double lowest_min_level = -140;        ///< [dB]
constexpr std::size_t max_feature_count = 5000;  ///< of a channel

/// Options of features as a person gives them: quantities with their units, "" where the default
/// is meant.
struct FeatureArguments {
  std::string method = "esprit";
  std::string onset, contact_time, duration, min_frequency, max_frequency, min_decay_rate;
  std::string explained;  ///< a fraction, or with "%"
  std::string rt60;       ///< one or several with commas between them, by octave from 125 Hz on
  double min_level = -40;
  std::size_t max_features = 100;
};

/// @throws InputError  a value that cannot be read or is out of range; names the option
FeatureOptions feature_options(const FeatureArguments& arguments);

}  // namespace carillon::eval::features
