#include "cli/feature_options.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "cli/command_line.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace carillon::cli {

namespace {

/// @throws InputError  names the option
double parse_argument(const std::string& text, core::Dimension dimension, const char* name) {
  try {
    return core::parse_quantity(text, dimension);
  } catch (const core::Error& error) {
    throw core::InputError(std::string(name) + ": " + error.message(), error.hint());
  }
}

}  // namespace

void add_feature_arguments(Command& command, FeatureArguments& arguments) {
  command
      .option("--method", arguments.method,
              "esprit: subspace and likelihood in bands; peaks: of spectrograms, as the papers")
      .one_of({"esprit", "peaks"})
      .show_default();
  command.option("--onset", arguments.onset, "where the strike begins; found by itself");
  command
      .option("--contact-time", arguments.contact_time,
              "left out after the onset: the object is still driven")
      .show_default("3 ms");
  command.option("--min-frequency", arguments.min_frequency, "of modes").show_default("20 Hz");
  command
      .option("--max-frequency", arguments.max_frequency,
              "of modes; at most 0.95 of half the sample rate")
      .show_default("20 kHz");
  command
      .option("--min-decay-rate", arguments.min_decay_rate,
              "what decays slower is taken for a hum [1/s]")
      .show_default("0.2");
  command.option("--rt60", arguments.rt60,
                 "reverberation time of the room, or T1,T2,... by octave from 125 Hz on: modes "
                 "that cannot be told from its decay are marked");
  command
      .option("--min-level", arguments.min_level,
              "energy of a mode against the strongest's, at least [dB]")
      .range(-140.0, 0.0)
      .show_default();
  command.option("--max-features", arguments.max_features, "modes at most")
      .range(1, 5000)
      .show_default();
}

eval::features::FeatureOptions feature_options(const FeatureArguments& arguments) {
  using core::Dimension;
  eval::features::FeatureOptions options;
  options.method = arguments.method == "peaks" ? eval::features::FeatureMethod::peaks
                                               : eval::features::FeatureMethod::esprit;
  const auto read = [](const std::string& text, Dimension dimension, const char* name,
                       auto& value) {
    if (!text.empty()) value = parse_argument(text, dimension, name);
  };
  read(arguments.onset, Dimension::time, "--onset", options.onset);
  read(arguments.contact_time, Dimension::time, "--contact-time", options.contact_time);
  read(arguments.min_frequency, Dimension::frequency, "--min-frequency", options.min_frequency);
  read(arguments.max_frequency, Dimension::frequency, "--max-frequency", options.max_frequency);
  read(arguments.min_decay_rate, Dimension::none, "--min-decay-rate", options.min_decay_rate);
  options.rt60 = parse_rt60(arguments.rt60);
  options.min_level = arguments.min_level;
  options.max_features = arguments.max_features;
  return options;
}

std::vector<double> parse_rt60(const std::string& text) {
  std::vector<double> times;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    times.push_back(
        parse_argument(text.substr(begin, end - begin), core::Dimension::time, "--rt60"));
    begin = end + 1;
  }
  return times;
}

}  // namespace carillon::cli
