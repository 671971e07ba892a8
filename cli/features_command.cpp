#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/feature_options.hpp"
#include "core/audio.hpp"
#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/trace.hpp"
#include "eval/features/feature_json.hpp"
#include "eval/features/read_clip.hpp"

namespace carillon::cli {

namespace {

struct FeaturesOptions {
  std::vector<std::string> files;
  eval::features::FeatureArguments features;
  std::string csv;
  std::string residual;
};

std::string csv_of(const std::vector<std::string>& files,
                   const std::vector<eval::features::FeatureSet>& sets) {
  std::string text =
      core::csv_line({"file", "frequency_hz", "decay_rate_per_s", "amplitude", "frequency_error_hz",
                      "decay_rate_error_per_s", "amplitude_error", "snr_db", "reverberant"});
  using core::csv_number;
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (const eval::features::Feature& f : sets[i].features) {
      text += core::csv_line({files[i], csv_number(f.frequency, 9), csv_number(f.decay_rate, 9),
                              csv_number(f.amplitude, 6), csv_number(f.frequency_error, 3),
                              csv_number(f.decay_rate_error, 3), csv_number(f.amplitude_error, 3),
                              fmt::format("{:.1f}", f.snr), f.reverberant ? "1" : "0"});
    }
  }
  return text;
}

void tell(const std::string& file, const eval::features::FeatureSet& set) {
  fmt::print("{}: {} mode{}", file, set.features.size(), set.features.size() == 1 ? "" : "s");
  if (set.nothing.empty()) {
    fmt::print(", {:.3g} % of the energy from {:.4f} to {:.4f} s (onset {:.4f} s)",
               100 * set.explained, set.begin, set.end, set.onset);
  } else {
    fmt::print(": {}", set.nothing);
  }
  fmt::print("\n");
  if (!set.features.empty()) {
    fmt::print("  {:>12} {:>9}  {:>10} {:>9}  {:>10} {:>8}  {:>6}\n", "f [Hz]", "+-", "d [1/s]",
               "+-", "amplitude", "+-", "SNR dB");
  }
  for (const eval::features::Feature& f : set.features) {
    fmt::print("  {:12.3f} {:9.2g}  {:10.4g} {:9.2g}  {:10.3g} {:8.2g}  {:6.1f}{}\n", f.frequency,
               f.frequency_error, f.decay_rate, f.decay_rate_error, f.amplitude, f.amplitude_error,
               f.snr, f.reverberant ? "  may be the room's" : "");
  }
  for (const eval::features::Hum& hum : set.hums) {
    fmt::print("  hum at {:.3f} Hz, d {:.3g} 1/s, amplitude {:.3g}: left out\n", hum.frequency,
               hum.decay_rate, hum.amplitude);
  }
  for (const std::string& remark : set.remarks) fmt::print("  {}\n", remark);
}

void run_features(const FeaturesOptions& options, Context& context) {
  if (!options.residual.empty() && options.files.size() > 1) {
    throw core::InputError("--residual takes one recording");
  }
  const eval::features::FeatureOptions wanted = eval::features::feature_options(options.features);
  if (!context.speaks()) return;
  const double start = core::monotonic_seconds();
  std::vector<eval::features::FeatureSet> sets;
  nlohmann::json files = nlohmann::json::array();
  bool failed = false;
  for (const std::string& file : options.files) {
    // One that cannot be used does not take the others with it.
    try {
      sets.push_back(eval::features::read_features(file, wanted));
    } catch (const core::Error& error) {
      if (options.files.size() == 1) throw;
      eval::features::FeatureSet none;
      none.nothing = error.message();
      sets.push_back(none);
      failed = true;
    }
    files.push_back(eval::features::to_json(sets.back()));
    files.back()["file"] = file;
    if (!context.json) tell(file, sets.back());
  }
  if (!options.csv.empty()) core::write_text_durably(options.csv, csv_of(options.files, sets));
  if (!options.residual.empty()) {
    const eval::features::FeatureSet& set = sets.front();
    core::write_wav(options.residual,
                    {{set.residual.begin(), set.residual.end()},
                     1,
                     static_cast<int>(std::lround(set.sample_rate))},
                    core::SampleFormat::float32);
  }
  if (context.json) {
    nlohmann::json json;
    if (files.size() == 1) json = files.front();
    json["files"] = std::move(files);
    json["timing"] = {{"features_s", core::monotonic_seconds() - start}};
    fmt::print("{}\n", json.dump(2));
  }
  if (failed) context.exit_code = mpi::exit_failures;
}

}  // namespace

void add_features(Program& program, Context& context) {
  auto options = std::make_shared<FeaturesOptions>();
  Command& command = program.add(
      "features", "modal features of recorded strikes: frequency, decay rate, amplitude, errors",
      Needs::nothing);
  command.option("recordings", options->files, "audio files, one strike each").required();
  add_feature_arguments(command, options->features);
  command.option("--csv", options->csv, "write a table, which `fit --features` reads");
  command.option("--residual", options->residual,
                 "write what the modes do not explain as a WAV file");
  command.footer(
      "Examples:\n  carillon features bowl.wav\n"
      "  carillon features plate-*.wav --rt60 0.4 --csv plate.csv\n"
      "Method and limits: docs/features.md");
  command.does([&context, options] { run_features(*options, context); });
}

}  // namespace carillon::cli
