#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/audio.hpp"
#include "core/csv.hpp"
#include "core/files.hpp"
#include "core/numbers.hpp"
#include "eval/recorded_objects/impact_report.hpp"

namespace carillon::eval::recorded_objects {

namespace {

/// A recorded mode, a synthetic one or a pair, as a line of modes.csv.
/// @param cells  whose: vertex, row, variant
std::string line_of(std::vector<std::string> cells, const features::Feature* recorded,
                    const features::Feature* synthetic, const perception::MatchedMode* pair) {
  const auto add = [&](double value, int digits) {
    cells.push_back(core::csv_number(value, digits));
  };
  for (const features::Feature* mode : {recorded, synthetic}) {
    add(mode == nullptr ? core::nan : mode->frequency, 6);
    add(mode == nullptr ? core::nan : mode->decay_rate, 6);
    add(mode == nullptr ? core::nan : mode->amplitude, 6);
  }
  add(pair == nullptr ? core::nan : pair->cents, 4);
  add(pair == nullptr ? core::nan : pair->decay_ratio, 5);
  add(pair == nullptr ? core::nan : pair->level, 4);
  return core::csv_line(cells);
}

std::string modes_csv(const ImpactReport& report) {
  std::string text =
      core::csv_line({"vertex", "row", "variant", "recorded_hz", "recorded_decay_per_s",
                      "recorded_amplitude", "synthetic_hz", "synthetic_decay_per_s",
                      "synthetic_amplitude", "pitch_cents", "decay_ratio", "level_db"});
  for (const ModelVariant& variant : report.variants) {
    for (std::size_t i = 0; i < report.strikes.size(); ++i) {
      const auto& recorded = report.strikes[i].set.features;
      const auto& synthetic = variant.modes.synthetic[i];
      const perception::ModeComparison& modes = variant.modes.strikes[i];
      const RecordedStrike& recorded_strike = report.strikes[i].recorded;
      const std::vector<std::string> labels = {std::to_string(recorded_strike.vertex),
                                               std::to_string(recorded_strike.row), variant.name};
      for (const perception::MatchedMode& pair : modes.matched) {
        text += line_of(labels, &recorded[pair.reference], &synthetic[pair.other], &pair);
      }
      for (const std::size_t k : modes.reference_only) {
        text += line_of(labels, &recorded[k], nullptr, nullptr);
      }
      for (const std::size_t k : modes.other_only) {
        text += line_of(labels, nullptr, &synthetic[k], nullptr);
      }
    }
  }
  return text;
}

/// The model's clips of a strike, in the recording's unit: as given, and fitted if there is a fit.
struct ModelClips {
  std::vector<double> given, fitted;
};

/// @param lead  silence before the hammer touches [samples]
/// @param gain  recording's unit per synthetic unit; NaN where nothing matched: 1
std::vector<double> model_clip(const ImpactReport& report, std::size_t strike,
                               const HeardObject& object,
                               const synth::damping::DampingModel& damping, double gain,
                               std::size_t lead, std::size_t count) {
  std::vector<double> clip(std::min(lead, count), 0.0);
  for (const double sample : synthetic_recording(object, report.model, strike, damping,
                                                 report.options.sample_rate, count - clip.size())) {
    clip.push_back(sample * (std::isfinite(gain) ? gain : 1));
  }
  return clip;
}

/// @param lead, count  as model_clip()
ModelClips model_clips(const ImpactReport& report, std::size_t strike, std::size_t lead,
                       std::size_t count) {
  ModelClips clips;
  clips.given = model_clip(report, strike, report.given, report.material.damping,
                           report.variants.front().modes.gain, lead, count);
  if (!report.fitted) return clips;
  clips.fitted = model_clip(report, strike, *report.fitted, report.fit->damping,
                            report.variants.back().modes.gain, lead, count);
  return clips;
}

std::string spectra_csv(const ImpactReport& report) {
  std::vector<std::string> cells = {"vertex", "row", "frequency_hz", "recorded_db", "as_given_db"};
  if (report.fitted) cells.push_back("fitted_db");
  std::string text = core::csv_line(cells);
  for (std::size_t i = 0; i < report.strikes.size(); ++i) {
    const recorded::WindowSpectrum& recorded = report.strikes[i].spectrum;
    const ModelClips clips = model_clips(report, i, 0, report.options.stretch.end);
    const auto spectrum = [&](const std::vector<double>& clip) {
      return recorded::window_spectrum(clip, report.options.sample_rate, report.options.stretch);
    };
    const recorded::WindowSpectrum given = spectrum(clips.given), fitted = spectrum(clips.fitted);
    for (std::size_t bin = 0; bin < recorded.amplitudes.size(); ++bin) {
      const auto level = [bin](const recorded::WindowSpectrum& of) {
        return fmt::format("{:.2f}", core::amplitude_decibels(std::max(of.amplitudes[bin], 1e-30)));
      };
      cells = {std::to_string(report.strikes[i].recorded.vertex),
               std::to_string(report.strikes[i].recorded.row),
               fmt::format("{:.3f}", static_cast<double>(bin) * recorded.bin_width),
               level(recorded), level(given)};
      if (report.fitted) cells.push_back(level(fitted));
      text += core::csv_line(cells);
    }
  }
  return text;
}

/// @param gain  full scale per recording's unit
void write_clip(const std::filesystem::path& path, const std::vector<double>& samples, double gain,
                double sample_rate) {
  core::AudioClip clip;
  clip.sample_rate = static_cast<int>(std::lround(sample_rate));
  for (const double sample : samples) clip.samples.push_back(static_cast<float>(gain * sample));
  core::write_wav(path, clip, core::SampleFormat::float32);
}

void write_clips(const std::filesystem::path& folder, const ImpactReport& report) {
  double peak = 0;
  std::vector<ModelClips> made;
  for (std::size_t i = 0; i < report.strikes.size(); ++i) {
    const StudiedStrike& strike = report.strikes[i];
    const double lead = strike.touch * report.options.sample_rate;
    made.push_back(
        model_clips(report, i, static_cast<std::size_t>(std::lround(lead)), strike.samples.size()));
    peak = std::max(peak, core::peak(strike.samples));
  }
  const double gain = 0.5 / peak;
  for (std::size_t i = 0; i < report.strikes.size(); ++i) {
    const StudiedStrike& strike = report.strikes[i];
    const auto path = [&](const char* kind) {
      return folder / fmt::format("vertex-{}-{}.wav", strike.recorded.vertex, kind);
    };
    const double rate = report.options.sample_rate;
    write_clip(path("recorded"), strike.samples, gain, rate);
    if (report.fitted) {
      write_clip(path("fitted"), made[i].fitted, gain, rate);
    } else {
      write_clip(path("as-given"), made[i].given, gain, rate);
    }
  }
}

}  // namespace

void write_report(const std::filesystem::path& folder, const ImpactReport& report) {
  core::write_text_durably(folder / "report.json", to_json(report).dump(2) + "\n");
  core::write_text_durably(folder / "modes.csv", modes_csv(report));
  core::write_text_durably(folder / "spectra.csv", spectra_csv(report));
  write_clips(folder, report);
}

}  // namespace carillon::eval::recorded_objects
