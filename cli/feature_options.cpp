#include "cli/feature_options.hpp"

#include "cli/command_line.hpp"

namespace carillon::cli {

void add_feature_arguments(Command& command, eval::features::FeatureArguments& arguments) {
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
  command.option("--duration", arguments.duration, "that is analysed after the contact, at most")
      .show_default("20 s");
  command.option("--min-frequency", arguments.min_frequency, "of modes").show_default("20 Hz");
  command
      .option("--max-frequency", arguments.max_frequency,
              "of modes; at most 0.95 of half the sample rate")
      .show_default("20 kHz");
  command
      .option(
          "--min-decay-rate", arguments.min_decay_rate,
          "what decays slower is a hum, all else a mode [1/s]; without it a hum is told by what "
          "was there before the strike")
      .show_default("by evidence");
  command.option(
      "--rt60", arguments.rt60,
      "reverberation time of the room, or T1,T2,... by octave from 125 Hz on: modes "
      "that cannot be told from its decay are marked; fit finds them by how the room decays");
  command
      .option("--min-level", arguments.min_level,
              "energy of a mode against the strongest's, at least [dB]")
      .range(eval::features::lowest_min_level, 0.0)
      .show_default();
  command
      .option("--explained", arguments.explained,
              "fraction of the power of the spectrograms that --method peaks is to account for")
      .show_default("99.99 %");
  command.option("--max-features", arguments.max_features, "modes at most")
      .range(std::size_t{1}, eval::features::max_feature_count)
      .show_default();
}

}  // namespace carillon::cli
