#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/features/read_clip.hpp"

namespace carillon::cli {

class Command;

/// What commands that analyse recordings take, as it was typed.
struct FeatureArguments {
  std::string method = "esprit";
  std::string onset, contact_time, min_frequency, max_frequency, min_decay_rate, rt60;
  double min_level = -60;
  std::size_t max_features = 300;
};

void add_feature_arguments(Command& command, FeatureArguments& arguments);

/// @throws InputError  a value that cannot be read; names the option
eval::features::FeatureOptions feature_options(const FeatureArguments& arguments);

/// Reverberation times, one or several with commas between them [s]; empty for "".
/// @throws InputError  names --rt60
std::vector<double> parse_rt60(const std::string& text);

}  // namespace carillon::cli
