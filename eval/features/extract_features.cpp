#include "eval/features/extract_features.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "eval/features/find_tones.hpp"
#include "eval/features/reverberation.hpp"
#include "eval/features/segment.hpp"
#include "eval/features/spectrogram_peaks.hpp"

namespace carillon::eval {

namespace {

using core::InputError;

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
  if (!(options.contact_time >= 0) || !(options.min_frequency > 0) ||
      !(options.max_frequency > options.min_frequency) || !(options.min_decay_rate >= 0)) {
    throw InputError("feature options out of range",
                     "contact time and least decay rate not negative, frequencies positive and "
                     "ascending");
  }
  const bool rooms =
      std::all_of(options.rt60.begin(), options.rt60.end(), [](double time) { return time >= 0; });
  if ((options.onset && !(*options.onset >= 0)) || !rooms) {
    throw InputError("feature options out of range",
                     "an onset must not be negative, neither must reverberation times");
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
  feature.snr = 10 * std::log10(energy(tone, fit.grid->count()) / noise);
  return feature;
}

/// What is left of the segment, and which share of it the features make up.
/// @param others  tones that count as neither: hums, and what is above the band
void account(std::span<const double> samples, std::span<const Tone> modes,
             std::span<const Tone> others, FeatureSet& set) {
  std::vector<double> without(samples.begin(), samples.end());
  const auto subtract = [&](const Tone& tone) {
    const std::complex<double> turn = std::exp(tone.rate);
    std::complex<double> value = tone.amplitude;
    for (double& sample : without) {
      sample -= value.real();
      value *= turn;
    }
  };
  for (const Tone& other : others) subtract(other);
  double all = 0, left = 0;
  for (const double sample : without) all += sample * sample;
  for (const Tone& mode : modes) subtract(mode);
  for (const double sample : without) left += sample * sample;
  set.explained = all > 0 ? 1 - left / all : 0;
  set.residual = std::move(without);
}

void by_esprit(std::span<const double> samples, double sample_rate, double after_onset,
               const FeatureOptions& options, FeatureSet& set) {
  // Modes just above the band bend those below it, unless they are known too.
  constexpr double beyond = 1.25, near_nyquist = 0.495;
  const double highest = std::min(options.max_frequency, 0.475 * sample_rate);
  const ToneFit fit =
      find_tones(samples, {sample_rate, options.min_frequency,
                           std::min(beyond * options.max_frequency, near_nyquist * sample_rate),
                           options.max_features, std::pow(10, options.min_level / 10)});
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
  account(samples, modes, others, set);
}

/// Samples from `begin` on that are analysed: a size that transforms fast.
std::size_t fitting_fft(std::size_t begin, std::size_t end) {
  return begin < end ? largest_fft_size(end - begin) : 0;
}

/// Looks at the sound again when the room has decayed by 20 dB, and marks what that does not bear
/// out.
void leave_room(std::span<const double> samples, const Segment& segment, double sample_rate,
                const FeatureOptions& options, FeatureSet& set) {
  const double wait = *std::max_element(options.rt60.begin(), options.rt60.end()) / 3;
  const auto begin =
      std::max(segment.begin, segment.onset + static_cast<std::size_t>(wait * sample_rate));
  const auto after_onset = static_cast<double>(begin - segment.onset);
  FeatureSet late;
  const std::size_t count = fitting_fft(begin, segment.end);
  if (count > 0) {
    by_esprit(samples.subspan(begin, count), sample_rate, after_onset, options, late);
  }
  set.features =
      without_room(std::move(set.features), late.features, after_onset / sample_rate, options.rt60);
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
    by_esprit(part, sample_rate, after_onset, options, set);
    if (!options.rt60.empty()) leave_room(samples, segment, sample_rate, options, set);
  }
  const auto by_frequency = [](const auto& a, const auto& b) { return a.frequency < b.frequency; };
  std::sort(set.features.begin(), set.features.end(), by_frequency);
  std::sort(set.hums.begin(), set.hums.end(), by_frequency);
  if (set.features.empty()) {
    set.nothing = set.hums.empty() ? "no decaying tone above the noise" : "only steady tones";
  }
  return set;
}

}  // namespace carillon::eval
