#include "eval/features/detail/features_by_tones.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/numbers.hpp"
#include "eval/features/detail/crowding.hpp"
#include "eval/features/detail/find_tones.hpp"
#include "eval/features/detail/judge_tones.hpp"
#include "eval/features/detail/tone_trials.hpp"

namespace carillon::eval::features {

namespace {

constexpr double slow_decay = 0.2;   ///< of a mode that is worth a word [1/s]
constexpr double hum_decay = 4;      ///< of a hum while it is heard, at most: ln of a ratio
constexpr double max_unheard = 2.3;  ///< ln of the ratio by which a mode decays before it is heard

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

/// "130.8, 261.9 and 311.4 Hz", or the first ten and how many there are.
std::string listed(std::vector<double> frequencies) {
  constexpr std::size_t maximum = 10;
  std::sort(frequencies.begin(), frequencies.end());
  std::string text;
  for (std::size_t k = 0; k < std::min(maximum, frequencies.size()); ++k) {
    const bool last = k + 1 == frequencies.size();
    text += fmt::format("{}{:.1f}", k == 0 ? "" : last ? " and " : ", ", frequencies[k]);
  }
  text += " Hz";
  if (frequencies.size() > maximum) {
    text += fmt::format(" and {} more", frequencies.size() - maximum);
  }
  return text;
}

/// Frequencies of tones that are not plainly modes [Hz], and how many are plainly none.
struct Doubts {
  std::vector<double> hums, slow, undetermined;
  std::size_t left_out = 0;
};

void remark(const Doubts& doubts, const FeatureOptions& options, FeatureSet& set) {
  if (!doubts.hums.empty() && !options.min_decay_rate) {
    set.remarks.push_back(fmt::format("taken for hum: {} (--min-decay-rate 0 keeps what decays)",
                                      listed(doubts.hums)));
  }
  if (!doubts.slow.empty() && !options.min_decay_rate) {
    set.remarks.push_back(
        fmt::format("kept as modes although they decay slower than {:g} 1/s: {} (--min-decay-rate "
                    "{:g} leaves them out)",
                    slow_decay, listed(doubts.slow), slow_decay));
  }
  if (!doubts.undetermined.empty()) {
    set.remarks.push_back(fmt::format("left out, as their decay rate is not determined: {}",
                                      listed(doubts.undetermined)));
  }
  if (doubts.left_out > 0) {
    const bool one = doubts.left_out == 1;
    set.remarks.push_back(fmt::format(
        "left out: {} tone{} that {} not decay as a mode does, parts of bursts and of other modes",
        doubts.left_out, one ? "" : "s", one ? "does" : "do"));
  }
}

Steadiness steadiness_of(const Feature& feature, const SoundPart& part, double sample_rate,
                         const FeatureOptions& options) {
  if (options.min_decay_rate) {
    return feature.decay_rate < *options.min_decay_rate ? Steadiness::hum : Steadiness::mode;
  }
  const double duration = static_cast<double>(part.samples.size()) / sample_rate;
  if (feature.decay_rate * duration > hum_decay) return Steadiness::mode;
  return steadiness({feature.frequency, feature.decay_rate, feature.decay_rate_error,
                     feature.amplitude, duration},
                    part.quiet, sample_rate);
}

/// Leaves out modes whose decay rate is not known to within itself, and notes which slow ones stay.
/// @param modes  the features' tones
void leave_out_undetermined(std::vector<Feature>& features, std::vector<Tone>& modes,
                            Doubts& doubts) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < features.size(); ++k) {
    if (!(features[k].decay_rate_error < features[k].decay_rate)) {
      doubts.undetermined.push_back(features[k].frequency);
      continue;
    }
    if (features[k].decay_rate < slow_decay) doubts.slow.push_back(features[k].frequency);
    features[kept] = features[k];
    modes[kept++] = modes[k];
  }
  features.resize(kept);
  modes.resize(kept);
}

/// Whether little of a tone is left when the object rings by itself: a burst of the strike, or part
/// of one.
bool is_extrapolated(const Tone& tone, const SoundPart& part) {
  return -tone.rate.real() * part.unheard > max_unheard;
}

/// What is left of a sound without the tones of a fit.
std::vector<double> residual_of(const ToneFit& fit, std::span<const double> samples) {
  std::vector<double> residual(samples.begin(), samples.end());
  for (const Tone& tone : fit.tones) add_tone(residual, tone, -1);
  return residual;
}

/// Takes out of a fit what is no mode, and refines the rest without it.
/// @return  how many tones were taken out
std::size_t leave_out_doubtful(ToneFit& fit, std::span<const double> samples) {
  constexpr int max_rounds = 4;
  std::size_t left_out = 0;
  for (int round = 0; round < max_rounds; ++round) {
    const std::vector<double> residual = residual_of(fit, samples);
    std::vector<std::size_t> doubtful = indistinct(fit);
    for (std::size_t k = 0; k < fit.tones.size(); ++k) {
      if (!judge(fit, k, residual).is_mode) doubtful.push_back(k);
    }
    if (doubtful.empty()) break;
    std::sort(doubtful.begin(), doubtful.end());
    doubtful.erase(std::unique(doubtful.begin(), doubtful.end()), doubtful.end());
    // The strongest may be fine once the others are gone.
    const auto energy_of = [&](std::size_t k) { return energy(fit.tones[k], fit.grid->count()); };
    std::sort(doubtful.begin(), doubtful.end(),
              [&](std::size_t a, std::size_t b) { return energy_of(a) < energy_of(b); });
    if (round + 1 < max_rounds) doubtful.resize((doubtful.size() + 1) / 2);
    std::sort(doubtful.rbegin(), doubtful.rend());
    for (const std::size_t k : doubtful) remove_tone(fit, k);
    left_out += doubtful.size();
    refine_all(fit, 3, Fineness::few_bins);
    prune(fit);
  }
  return left_out;
}

}  // namespace

void features_by_tones(const SoundPart& part, double sample_rate, const FeatureOptions& options,
                       FeatureSet& set) {
  // Modes just above the band bend those below it, unless they are known too.
  constexpr double beyond = 1.25, near_nyquist = 0.495;
  const double highest = std::min(options.max_frequency, highest_frequency * sample_rate);
  // The strongest are found first, but for those that others hide.
  const std::size_t maximum = 2 * options.max_features + 50;
  ToneFit fit = find_tones(
      part.samples, {sample_rate, options.min_frequency,
                     std::min(beyond * options.max_frequency, near_nyquist * sample_rate), maximum,
                     std::pow(10, options.min_level / 10)});
  Doubts doubts;
  doubts.left_out = leave_out_doubtful(fit, part.samples);
  const std::vector<double> residual = residual_of(fit, part.samples);
  std::vector<Feature> found;
  std::vector<bool> none(fit.tones.size(), false);
  for (std::size_t k = 0; k < fit.tones.size(); ++k) {
    found.push_back(feature_of(fit, k, sample_rate, part.after_onset));
    none[k] = is_extrapolated(fit.tones[k], part);
  }
  none = depending_on(fit, std::move(none));
  std::vector<Tone> modes, others;
  for (std::size_t k = 0; k < fit.tones.size(); ++k) {
    const Tone& tone = fit.tones[k];
    Feature& feature = found[k];
    if (feature.frequency > highest) {
      others.push_back(tone);
      continue;
    }
    const Steadiness steady = steadiness_of(feature, part, sample_rate, options);
    if (steady == Steadiness::hum) {
      set.hums.push_back({feature.frequency, feature.decay_rate, std::abs(tone.amplitude)});
      doubts.hums.push_back(feature.frequency);
      others.push_back(tone);
    } else if (none[k] || steady == Steadiness::neither) {
      ++doubts.left_out;
    } else {
      // ln a(t) = -d t changes by the drift at about 2 / d.
      const double shift = 0.5 * judge(fit, k, residual).drift * feature.decay_rate;
      feature.decay_rate_error = std::hypot(feature.decay_rate_error, shift);
      feature.frequency_error = std::hypot(feature.frequency_error, shift / (2 * std::numbers::pi));
      set.features.push_back(feature);
      modes.push_back(tone);
    }
  }
  widen_crowded(set.features);
  leave_out_undetermined(set.features, modes, doubts);
  remark(doubts, options, set);
  keep_strongest(options.max_features, part.samples.size(), modes, set);
  account(part.samples, modes, others, set);
}

}  // namespace carillon::eval::features
