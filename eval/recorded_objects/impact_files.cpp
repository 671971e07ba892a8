#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/audio.hpp"
#include "core/files.hpp"
#include "core/numbers.hpp"
#include "eval/recorded_objects/impact_report.hpp"

namespace carillon::eval::recorded_objects {

namespace {

/// A number as a cell of a table; none: an empty one.
std::string cell(double value, int digits) {
  return std::isnan(value) ? std::string(",") : fmt::format(",{:.{}g}", value, digits);
}

/// A recorded mode, a synthetic one or a pair, as a line of modes.csv.
std::string line_of(const features::Feature* recorded, const features::Feature* synthetic,
                    const perception::MatchedMode* pair) {
  const auto mode = [](const features::Feature* feature) {
    return feature == nullptr ? std::string(",,,")
                              : cell(feature->frequency, 6) + cell(feature->decay_rate, 6) +
                                    cell(feature->amplitude, 6);
  };
  return mode(recorded) + mode(synthetic) +
         (pair == nullptr
              ? std::string(",,,\n")
              : cell(pair->cents, 4) + cell(pair->decay_ratio, 5) + cell(pair->level, 4) + "\n");
}

std::string modes_csv(const ImpactReport& report) {
  std::string text =
      "vertex,row,variant,recorded_hz,recorded_decay_per_s,recorded_amplitude,synthetic_hz,"
      "synthetic_decay_per_s,synthetic_amplitude,pitch_cents,decay_ratio,level_db\n";
  for (const ModelVariant& variant : report.variants) {
    for (std::size_t i = 0; i < report.blows.size(); ++i) {
      const auto& recorded = report.blows[i].set.features;
      const auto& synthetic = variant.modes.synthetic[i];
      const perception::ModeComparison& modes = variant.modes.blows[i];
      const std::string begin = fmt::format("{},{},{}", report.blows[i].recorded.vertex,
                                            report.blows[i].recorded.row, variant.name);
      for (const perception::MatchedMode& pair : modes.matched) {
        text += begin + line_of(&recorded[pair.reference], &synthetic[pair.other], &pair);
      }
      for (const std::size_t k : modes.reference_only) {
        text += begin + line_of(&recorded[k], nullptr, nullptr);
      }
      for (const std::size_t k : modes.other_only) {
        text += begin + line_of(nullptr, &synthetic[k], nullptr);
      }
    }
  }
  return text;
}

/// The model's clips of a blow, in the recording's unit: as given, and fitted if there is a fit.
struct ModelClips {
  std::vector<double> given, fitted;
};

ModelClips model_clips(const ImpactReport& report, std::size_t blow, std::size_t count) {
  const double rate = report.options.sample_rate;
  ModelClips clips;
  clips.given =
      synthetic_recording(report.given, report.model, blow, report.material.damping, rate, count);
  for (double& sample : clips.given) sample *= report.variants.front().modes.gain;
  if (report.fit == nullptr) return clips;
  clips.fitted =
      synthetic_recording(*report.fitted, report.model, blow, report.fit->damping, rate, count);
  for (double& sample : clips.fitted) sample *= report.variants.back().modes.gain;
  return clips;
}

double level_of(double amplitude) {
  return core::amplitude_decibels(std::max(amplitude, 1e-30));
}

std::string spectra_csv(const ImpactReport& report) {
  std::string text = "vertex,row,frequency_hz,recorded_db,as_given_db";
  text += report.fit != nullptr ? ",fitted_db\n" : "\n";
  for (std::size_t i = 0; i < report.blows.size(); ++i) {
    const recorded::WindowSpectrum& recorded = report.blows[i].spectrum;
    const ModelClips clips = model_clips(report, i, report.options.stretch.end);
    const auto spectrum = [&](const std::vector<double>& clip) {
      return recorded::window_spectrum(clip, report.options.sample_rate, report.options.stretch);
    };
    const recorded::WindowSpectrum given = spectrum(clips.given), fitted = spectrum(clips.fitted);
    for (std::size_t bin = 0; bin < recorded.amplitudes.size(); ++bin) {
      text +=
          fmt::format("{},{},{:.3f},{:.2f},{:.2f}", report.blows[i].recorded.vertex,
                      report.blows[i].recorded.row, static_cast<double>(bin) * recorded.bin_width,
                      level_of(recorded.amplitudes[bin]), level_of(given.amplitudes[bin]));
      text += report.fit != nullptr ? fmt::format(",{:.2f}\n", level_of(fitted.amplitudes[bin]))
                                    : std::string("\n");
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
  double loudest = 0;
  std::vector<ModelClips> made;
  for (std::size_t i = 0; i < report.blows.size(); ++i) {
    const StudiedBlow& blow = report.blows[i];
    made.push_back(model_clips(report, i, blow.samples.size()));
    for (const double sample : blow.samples) loudest = std::max(loudest, std::abs(sample));
  }
  const double gain = 0.5 / loudest;
  for (std::size_t i = 0; i < report.blows.size(); ++i) {
    const StudiedBlow& blow = report.blows[i];
    const auto path = [&](const char* kind) {
      return folder / fmt::format("vertex-{}-{}.wav", blow.recorded.vertex, kind);
    };
    const double rate = report.options.sample_rate;
    write_clip(path("recorded"), blow.samples, gain, rate);
    if (report.fit != nullptr) {
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
