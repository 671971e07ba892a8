#include "eval/features/feature_arguments.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/units.hpp"

namespace carillon::eval::features {

namespace {

using core::Dimension;
using core::InputError;

/// @throws InputError  names the option
double parse_argument(const std::string& text, Dimension dimension, const char* name) {
  try {
    return core::parse_quantity(text, dimension);
  } catch (const core::Error& error) {
    throw InputError(fmt::format("{}: {}", name, error.message()), error.hint());
  }
}

std::vector<double> parse_rt60(const std::string& text) {
  std::vector<double> times;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    times.push_back(parse_argument(text.substr(begin, end - begin), Dimension::time, "--rt60"));
    begin = end + 1;
  }
  return times;
}

}  // namespace

FeatureOptions feature_options(const FeatureArguments& arguments) {
  FeatureOptions options;
  if (arguments.method == "peaks") {
    options.method = FeatureMethod::peaks;
  } else if (arguments.method != "esprit") {
    throw InputError(fmt::format("--method: there is no {}", arguments.method),
                     "methods are esprit and peaks");
  }
  const auto read = [](const std::string& text, Dimension dimension, const char* name,
                       auto& value) {
    if (!text.empty()) value = parse_argument(text, dimension, name);
  };
  read(arguments.onset, Dimension::time, "--onset", options.onset);
  read(arguments.contact_time, Dimension::time, "--contact-time", options.contact_time);
  read(arguments.duration, Dimension::time, "--duration", options.duration);
  read(arguments.min_frequency, Dimension::frequency, "--min-frequency", options.min_frequency);
  read(arguments.max_frequency, Dimension::frequency, "--max-frequency", options.max_frequency);
  read(arguments.min_decay_rate, Dimension::none, "--min-decay-rate", options.min_decay_rate);
  options.rt60 = parse_rt60(arguments.rt60);
  if (!(arguments.min_level >= lowest_min_level && arguments.min_level <= 0)) {
    throw InputError(fmt::format("--min-level: {} dB lies outside {:g} to 0 dB",
                                 arguments.min_level, lowest_min_level));
  }
  if (arguments.max_features < 1 || arguments.max_features > max_feature_count) {
    throw InputError(fmt::format("--max-features: {} lies outside 1 to {}", arguments.max_features,
                                 max_feature_count));
  }
  read(arguments.explained, Dimension::none, "--explained", options.explained);
  if (!(options.explained > 0 && options.explained <= 1)) {
    throw InputError(fmt::format("--explained: {:g} lies outside 0 to 100 %", options.explained));
  }
  options.min_level = arguments.min_level;
  options.max_features = arguments.max_features;
  return options;
}

}  // namespace carillon::eval::features
