#include "eval/perception/compare_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/json.hpp"

namespace carillon::eval::perception {

namespace {

nlohmann::json only_json(const features::FeatureSet& set, const std::vector<std::size_t>& places) {
  nlohmann::json modes = nlohmann::json::array();
  for (const std::size_t place : places) {
    const features::Feature& mode = set.features[place];
    modes.push_back({{"frequency_hz", mode.frequency},
                     {"decay_rate_per_s", mode.decay_rate},
                     {"amplitude", mode.amplitude}});
  }
  return modes;
}

nlohmann::json summary_json(const JndSummary& summary) {
  return {{"mean", core::number_or_null(summary.mean)},
          {"worst", core::number_or_null(summary.worst)}};
}

nlohmann::json sound_json(const std::string& file, const HeardSound& sound, double loudest) {
  return {{"file", file},
          {"sample_rate_hz", sound.set.sample_rate},
          {"onset_s", sound.set.onset},
          {"modes", sound.set.features.size()},
          {"loudest_sone", loudest},
          {"remarks", sound.set.remarks},
          {"nothing", sound.set.nothing}};
}

/// A number, or a dash where there is none.
std::string figure(double value, int width, int digits) {
  return std::isnan(value) ? fmt::format("{:>{}}", "-", width)
                           : fmt::format("{:{}.{}f}", value, width, digits);
}

void print_unmatched(const std::string& file, const features::FeatureSet& set,
                     const std::vector<std::size_t>& places) {
  for (const std::size_t place : places) {
    const features::Feature& mode = set.features[place];
    fmt::print("  {:12.3f}  d {:.4g} 1/s, amplitude {:.3g}: only in {}\n", mode.frequency,
               mode.decay_rate, mode.amplitude, file);
  }
}

void print_modes(const ComparedFiles& compared) {
  const ModeComparison& modes = compared.comparison.modes;
  for (const auto* sound : {&compared.reference, &compared.other}) {
    if (sound->set.nothing.empty()) continue;
    fmt::print("{}: no modes: {}\n",
               sound == &compared.reference ? compared.reference_file : compared.other_file,
               sound->set.nothing);
  }
  if (!modes.matched.empty()) {
    fmt::print("  {:>12}  {:>8} {:>7}  {:>8} {:>7}  {:>8} {:>7}\n", "f [Hz]", "cents", "JND",
               "d ratio", "JND", "level dB", "JND");
  }
  for (const MatchedMode& pair : modes.matched) {
    fmt::print("  {:12.3f}  {:+8.2f} {:7.2f}  {:8.3f} {}  {:+8.2f} {:7.2f}\n",
               compared.reference.set.features[pair.reference].frequency, pair.cents,
               pair.pitch_jnd, pair.decay_ratio, figure(pair.decay_jnd, 7, 2), pair.level,
               pair.level_jnd);
  }
  print_unmatched(compared.reference_file, compared.reference.set, modes.reference_only);
  print_unmatched(compared.other_file, compared.other.set, modes.other_only);
  fmt::print("matched modes: {} of {} and {}", modes.matched.size(),
             compared.reference.set.features.size(), compared.other.set.features.size());
  if (!std::isnan(modes.unmatched_level)) {
    fmt::print("; {} % and {} % of the energy", figure(100 * modes.reference_fraction, 0, 2),
               figure(100 * modes.other_fraction, 0, 2));
    if (std::isfinite(modes.unmatched_level)) {
      fmt::print(", {:.1f} dB of both unmatched", modes.unmatched_level);
    }
  }
  fmt::print("\n");
  const auto tell = [](const char* name, const JndSummary& summary) {
    fmt::print("{:<6} {} JND on average, {} at worst\n", name, figure(summary.mean, 6, 2),
               figure(summary.worst, 0, 2));
  };
  tell("pitch", modes.pitch);
  tell("decay", modes.decay);
  tell("level", modes.level);
}

}  // namespace

nlohmann::json to_json(const ComparedFiles& compared) {
  const SoundComparison& comparison = compared.comparison;
  const ModeComparison& modes = comparison.modes;
  nlohmann::json matched = nlohmann::json::array();
  for (const MatchedMode& pair : modes.matched) {
    const features::Feature& mode = compared.reference.set.features[pair.reference];
    const features::Feature& other = compared.other.set.features[pair.other];
    matched.push_back({{"frequency_hz", mode.frequency},
                       {"other_frequency_hz", other.frequency},
                       {"decay_rate_per_s", mode.decay_rate},
                       {"other_decay_rate_per_s", other.decay_rate},
                       {"pitch_cents", pair.cents},
                       {"pitch_jnd", pair.pitch_jnd},
                       {"decay_ratio", pair.decay_ratio},
                       {"decay_jnd", core::number_or_null(pair.decay_jnd)},
                       {"level_db", pair.level},
                       {"level_jnd", pair.level_jnd},
                       {"weight", pair.weight}});
  }
  return {
      {"reference", sound_json(compared.reference_file, compared.reference,
                               comparison.loudness.reference_loudest)},
      {"other", sound_json(compared.other_file, compared.other, comparison.loudness.other_loudest)},
      {"compared_s", comparison.seconds},
      {"sample_rate_hz", comparison.sample_rate},
      {"level_db", core::number_or_null(comparison.level)},
      {"matched", matched},
      {"reference_only", only_json(compared.reference.set, modes.reference_only)},
      {"other_only", only_json(compared.other.set, modes.other_only)},
      {"reference_matched_energy", core::number_or_null(modes.reference_fraction)},
      {"other_matched_energy", core::number_or_null(modes.other_fraction)},
      {"unmatched_energy_db", core::number_or_null(modes.unmatched_level)},
      {"jnd",
       {{"pitch", summary_json(modes.pitch)},
        {"decay", summary_json(modes.decay)},
        {"level", summary_json(modes.level)}}},
      {"loudness",
       {{"rms_sone_per_bark", comparison.loudness.rms},
        {"fraction", core::number_or_null(comparison.loudness.fraction)}}},
      {"spectra",
       {{"convergence", comparison.spectra.convergence},
        {"log_magnitude", comparison.spectra.log_magnitude},
        {"total", comparison.spectra.total()}}}};
}

void print_comparison(const ComparedFiles& compared) {
  const SoundComparison& comparison = compared.comparison;
  fmt::print("{} against {}: {:.3f} s from both onsets at {:g} Hz\n", compared.other_file,
             compared.reference_file, comparison.seconds, comparison.sample_rate);
  print_modes(compared);
  if (std::isfinite(comparison.level)) fmt::print("energy {:+.2f} dB\n", comparison.level);
  fmt::print(
      "loudness: {:.1f} and {:.1f} sone at the loudest, differing by {:.3f} sone/Bark rms "
      "({} % of both)\n",
      comparison.loudness.reference_loudest, comparison.loudness.other_loudest,
      comparison.loudness.rms, figure(100 * comparison.loudness.fraction, 0, 1));
  fmt::print("short-time spectra: {:.4f} (convergence {:.4f}, log magnitude {:.4f})\n",
             comparison.spectra.total(), comparison.spectra.convergence,
             comparison.spectra.log_magnitude);
}

}  // namespace carillon::eval::perception
