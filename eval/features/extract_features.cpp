#include "eval/features/extract_features.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/features/detail/find_tones.hpp"
#include "eval/features/detail/reverberation.hpp"
#include "eval/features/detail/spectrogram_peaks.hpp"
#include "eval/features/segment.hpp"

namespace carillon::eval::features {

namespace {

using core::InputError;

constexpr double highest_frequency = 0.475;  ///< frequency that is looked at, of the sample rate
constexpr double longest = 1e6;              ///< of times that are given [s]

void check(std::span<const double> samples, double sample_rate, const FeatureOptions& options) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw InputError(fmt::format("a sample rate of {} Hz", sample_rate), "it must be positive");
  }
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if (!std::isfinite(samples[n])) {
      throw InputError(fmt::format("sample {} (at {:.4f} s) is {}", n,
                                   static_cast<double>(n) / sample_rate, samples[n]),
                       "cut the recording there, or export it again");
    }
  }
  const auto require = [](bool holds, const char* text) {
    if (!holds) throw InputError(text);
  };
  const auto is_time = [](double time) { return time >= 0 && time < longest; };
  require(is_time(options.contact_time), "contact_time must be from 0 to 1e6 s");
  require(options.min_decay_rate >= 0, "min_decay_rate must not be negative");
  require(options.min_frequency > 0, "min_frequency must be positive");
  require(options.max_frequency > options.min_frequency,
          "max_frequency must lie above min_frequency");
  require(!options.onset || is_time(*options.onset), "the onset must be from 0 to 1e6 s");
  require(std::all_of(options.rt60.begin(), options.rt60.end(), is_time),
          "reverberation times (rt60) must be from 0 to 1e6 s");
  if (options.min_frequency > highest_frequency * sample_rate) {
    throw InputError(
        fmt::format("no mode can lie above {:g} Hz in a recording of {:g} Hz",
                    options.min_frequency, sample_rate),
        fmt::format("a least frequency below {:g} Hz", highest_frequency * sample_rate));
  }
}

/// A tone of the segment as a feature of the sound from its onset on.
Feature feature_of(const ToneFit& fit, std::size_t index, double sample_rate, double after_onset) {
  const Tone& tone = fit.tones[index];
  const ToneErrors errors = errors_of(fit, index);
  Feature feature;
  const double radian = sample_rate / (2 * std::numbers::pi);
  feature.frequency = tone.rate.imag() * radian;
  feature.decay_rate = -tone.rate.real() * sample_rate;
  const double size = std::abs(tone.amplitude);
  feature.amplitude = size * std::exp(-tone.rate.real() * after_onset);
  feature.phase = std::remainder(std::arg(tone.amplitude) - tone.rate.imag() * after_onset,
                                 2 * std::numbers::pi);
  // Where the residual is more than noise, the tone is not quite what it is taken for.
  const double misfit = std::sqrt(errors.misfit);
  feature.frequency_error = misfit * errors.rate_imag * radian;
  feature.decay_rate_error = misfit * errors.rate_real * sample_rate;
  // ln a(onset) = ln a(begin) - rate after_onset
  const double relative = errors.amplitude_real / size;
  const double variance = relative * relative + std::pow(after_onset * errors.rate_real, 2) -
                          2 * after_onset * errors.covariance / size;
  feature.amplitude_error = misfit * feature.amplitude * std::sqrt(std::max(0.0, variance));
  const double bin =
      tone.rate.imag() * static_cast<double>(fit.grid->count()) / (2 * std::numbers::pi);
  const double noise = fit.noise[std::min(fit.noise.size() - 1, static_cast<std::size_t>(bin))] /
                       static_cast<double>(fit.grid->count());
  feature.snr = core::decibels(energy(tone, fit.grid->count()) / noise);
  return feature;
}

/// What is left of the segment, and which share of it the features make up.
/// @param others  tones that count as neither: hums, and what is above the band
void account(std::span<const double> samples, std::span<const Tone> modes,
             std::span<const Tone> others, FeatureSet& set) {
  std::vector<double> without(samples.begin(), samples.end());
  for (const Tone& other : others) add_tone(without, other, -1);
  // About the mean: an offset is no sound.
  const auto energy_of = [&] {
    double sum = 0, squares = 0;
    for (const double sample : without) {
      sum += sample;
      squares += sample * sample;
    }
    return squares - sum * sum / static_cast<double>(without.size());
  };
  const double all = energy_of();
  for (const Tone& mode : modes) add_tone(without, mode, -1);
  const double left = energy_of();
  set.explained = all > 0 ? 1 - left / all : 0;
  set.residual = std::move(without);
}

/// Leaves out all but the modes of most energy.
void keep_strongest(std::size_t maximum, std::size_t count, std::vector<Tone>& modes,
                    FeatureSet& set) {
  if (modes.size() <= maximum) return;
  std::vector<std::size_t> order(modes.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return energy(modes[a], count) > energy(modes[b], count);
  });
  std::vector<Tone> tones;
  std::vector<Feature> features;
  for (std::size_t k = 0; k < maximum; ++k) {
    tones.push_back(modes[order[k]]);
    features.push_back(set.features[order[k]]);
  }
  set.remarks.push_back(
      fmt::format("{} weaker modes and more are left out", modes.size() - maximum));
  modes = std::move(tones);
  set.features = std::move(features);
}

void by_esprit(std::span<const double> samples, double sample_rate, double after_onset,
               const FeatureOptions& options, FeatureSet& set) {
  // Modes just above the band bend those below it, unless they are known too.
  constexpr double beyond = 1.25, near_nyquist = 0.495;
  const double highest = std::min(options.max_frequency, highest_frequency * sample_rate);
  // The strongest are found first, but for those that others hide.
  const std::size_t maximum = 2 * options.max_features + 50;
  const ToneFit fit =
      find_tones(samples, {sample_rate, options.min_frequency,
                           std::min(beyond * options.max_frequency, near_nyquist * sample_rate),
                           maximum, std::pow(10, options.min_level / 10)});
  std::vector<Tone> modes, others;
  for (std::size_t k = 0; k < fit.tones.size(); ++k) {
    const Tone& tone = fit.tones[k];
    const Feature feature = feature_of(fit, k, sample_rate, after_onset);
    if (feature.frequency > highest) {
      others.push_back(tone);
    } else if (feature.decay_rate < options.min_decay_rate) {
      set.hums.push_back({feature.frequency, feature.decay_rate, std::abs(tone.amplitude)});
      others.push_back(tone);
    } else if (!(feature.decay_rate_error < feature.decay_rate)) {
      // Neither hum nor mode: its decay cannot be told from none.
      set.remarks.push_back(
          fmt::format("a tone at {:.1f} Hz is left out: decay rate {:.3g} +- {:.3g}",
                      feature.frequency, feature.decay_rate, feature.decay_rate_error));
    } else {
      set.features.push_back(feature);
      modes.push_back(tone);
    }
  }
  keep_strongest(options.max_features, samples.size(), modes, set);
  account(samples, modes, others, set);
}

/// Samples from `begin` on that are analysed: a size that transforms fast.
std::size_t fitting_fft(std::size_t begin, std::size_t end) {
  return begin < end ? largest_fft_size(end - begin) : 0;
}

/// The segment from where the room has decayed by 20 dB.
Segment late_segment(const Segment& segment, double sample_rate, const FeatureOptions& options) {
  const double wait = core::median(options.rt60) / 3 * sample_rate;
  Segment late = segment;
  const auto left = static_cast<double>(segment.end - segment.onset);
  late.begin =
      std::max(segment.begin, segment.onset + static_cast<std::size_t>(std::min(wait, left)));
  return late;
}

/// Modes in the late part of the sound that are not the room's.
std::vector<Feature> modes_after_room(std::span<const double> samples, const Segment& segment,
                                      double sample_rate, const FeatureOptions& options,
                                      FeatureSet& set) {
  FeatureSet late;
  const std::size_t count = fitting_fft(segment.begin, segment.end);
  const auto after_onset = static_cast<double>(segment.begin - segment.onset);
  if (count > 0) {
    by_esprit(samples.subspan(segment.begin, count), sample_rate, after_onset, options, late);
  }
  const Late part{after_onset / sample_rate, static_cast<double>(count) / sample_rate};
  const double needed = time_to_stand_out(std::log(1000.0) / core::median(options.rt60));
  if (part.length < needed) {
    set.remarks.push_back(
        fmt::format("too short to tell modes from the room: they must be heard until {:.2f} s "
                    "after the onset at least",
                    part.begin + needed));
  }
  if (!options.keep_reverberant) {
    set.explained = late.explained;
    set.hums = std::move(late.hums);
    set.residual = std::move(late.residual);
  }
  return outlasting(late.features, part, options.rt60);
}

}  // namespace

FeatureSet extract_features(std::span<const double> samples, double sample_rate,
                            const FeatureOptions& options) {
  check(samples, sample_rate, options);
  FeatureSet set;
  set.sample_rate = sample_rate;
  const Segment segment = find_segment(samples, sample_rate, options.onset, options.contact_time);
  set.onset = static_cast<double>(segment.onset) / sample_rate;
  set.begin = static_cast<double>(segment.begin) / sample_rate;
  set.end = static_cast<double>(segment.end) / sample_rate;
  set.clipped = segment.clipped;
  set.remarks = segment.remarks;
  set.nothing = segment.nothing;
  if (!set.nothing.empty()) return set;

  const auto part = samples.subspan(segment.begin, fitting_fft(segment.begin, segment.end));
  set.end = static_cast<double>(segment.begin + part.size()) / sample_rate;
  const auto after_onset = static_cast<double>(segment.begin - segment.onset);
  if (options.method == FeatureMethod::peaks) {
    by_peaks(part, sample_rate, after_onset, options, set);
    if (!options.rt60.empty()) mark_faster(options.rt60, set.features);
  } else {
    const bool in_room =
        std::any_of(options.rt60.begin(), options.rt60.end(), [](double time) { return time > 0; });
    if (!in_room || options.keep_reverberant) {
      by_esprit(part, sample_rate, after_onset, options, set);
    }
    if (in_room) {
      const Segment late = late_segment(segment, sample_rate, options);
      const auto modes = modes_after_room(samples, late, sample_rate, options, set);
      if (!options.keep_reverberant) set.begin = static_cast<double>(late.begin) / sample_rate;
      set.features = replaced_by(modes, std::move(set.features), options.rt60);
    }
  }
  const auto by_frequency = [](const auto& a, const auto& b) { return a.frequency < b.frequency; };
  std::sort(set.features.begin(), set.features.end(), by_frequency);
  std::sort(set.hums.begin(), set.hums.end(), by_frequency);
  if (set.features.empty()) {
    set.nothing = !set.hums.empty()          ? "only steady tones"
                  : options.keep_reverberant ? "no decaying tone above the noise"
                                             : "no decaying tone above the noise and the room";
  }
  return set;
}

}  // namespace carillon::eval::features
