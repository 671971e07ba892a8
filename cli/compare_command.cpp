#include <fmt/format.h>

#include <memory>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/feature_options.hpp"
#include "cli/recording.hpp"
#include "core/error.hpp"
#include "core/trace.hpp"
#include "eval/perception/compare_report.hpp"

namespace carillon::cli {

namespace {

struct CompareOptions {
  std::string reference, other;
  int channel = 1;
  double loudest_level = 80;
  double widest = 100;
  eval::features::FeatureArguments features;
};

eval::perception::HeardSound hear(const std::string& file, int channel,
                                  const eval::features::FeatureOptions& options) {
  ChannelClip clip = read_channel(file, channel);
  try {
    eval::features::FeatureSet set =
        eval::features::extract_features(clip.samples, clip.sample_rate, options);
    return {std::move(clip.samples), std::move(set)};
  } catch (const core::InputError& error) {
    throw core::InputError(file + ": " + error.message(), error.hint());
  }
}

void run_compare(const CompareOptions& options, Context& context) {
  const eval::features::FeatureOptions wanted = eval::features::feature_options(options.features);
  eval::perception::SoundComparisonOptions how;
  how.loudest_level = options.loudest_level;
  how.modes.widest = options.widest;
  if (!context.speaks()) return;
  const double start = core::monotonic_seconds();
  eval::perception::ComparedFiles compared{options.reference,
                                           options.other,
                                           hear(options.reference, options.channel, wanted),
                                           hear(options.other, options.channel, wanted),
                                           {}};
  compared.comparison = eval::perception::compare_sounds(compared.reference, compared.other, how);
  if (context.json) {
    nlohmann::json document = eval::perception::to_json(compared);
    document["timing"] = {{"compare_s", core::monotonic_seconds() - start}};
    fmt::print("{}\n", document.dump(2));
  } else {
    eval::perception::print_comparison(compared);
  }
}

}  // namespace

void add_compare(Program& program, Context& context) {
  auto options = std::make_shared<CompareOptions>();
  Command& command = program.add("compare",
                                 "two sounds of one object: errors of modes in "
                                 "just-noticeable differences, loudness, spectra",
                                 Needs::nothing);
  command.option("reference", options->reference, "audio file").required();
  command.option("other", options->other, "audio file that is compared with it").required();
  command.option("--channel", options->channel, "of both, from 1").range(1, 1000).show_default();
  command
      .option("--loudest-level", options->loudest_level,
              "that the louder one's loudest moment is heard at [dB re 20 uPa]")
      .range(0.0, 140.0)
      .show_default();
  command.option("--widest", options->widest, "modes further apart are not the same [cents]")
      .range(0.1, 2400.0)
      .show_default();
  add_feature_arguments(command, options->features);
  command.footer(
      "Example:\n"
      "  carillon estimate bowl.wav bowl.obj --at 0.06,0,0.05 --poisson-ratio 0.2 -o again.wav\n"
      "  carillon compare bowl.wav again.wav\n"
      "What the numbers mean: docs/comparison.md");
  command.does([&context, options] { run_compare(*options, context); });
}

}  // namespace carillon::cli
