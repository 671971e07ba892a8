#include "eval/features/detail/find_tones.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>

#include "eval/features/detail/noise_floor.hpp"
#include "eval/features/detail/tone_trials.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::eval::features {

namespace {

using Complex = std::complex<double>;

/// Noise that is assumed at least, of the strongest bin's power.
constexpr double dynamic_range = 1e-14;
constexpr double grid_ratio = 3;
constexpr double max_decay_rate = 2000;  ///< decay rate [1/s]
/// Over the mean of what is left around it at the same decay rate: noise that was louder at first,
/// or tones too dense to be told apart, have peaks too.
constexpr double above_clutter = 8;
/// Of all that is left: where nothing stands out, what makes up more is no clutter, as broad and
/// dense as the tones may be.
constexpr double of_all = 0.01;
constexpr std::size_t max_candidates = 200;
/// Of the power of the tones that are known: real modes are not quite damped sinusoids.
constexpr double model_error = 1e-4;
constexpr int max_rounds = 10;
/// Fall of the noise (mean of its logarithm) that is worth another refinement.
constexpr double settled = 0.003;

struct Candidate {
  Complex rate;
  double gain = 0;
  double threshold = new_tone;
};

/// Transforms by size: making a plan takes as long as some transforms.
class Transforms {
 public:
  synth::signal::RealFft& of(std::size_t size) {
    auto& transform = by_size_[size];
    if (!transform) transform = std::make_unique<synth::signal::RealFft>(size);
    return *transform;
  }

 private:
  std::map<std::size_t, std::unique_ptr<synth::signal::RealFft>> by_size_;
};

std::vector<double> signal_of(const ToneFit& fit, Transforms& transforms) {
  synth::signal::RealFft& fft = transforms.of(fit.grid->count());
  std::fill(fft.spectrum().begin(), fft.spectrum().end(), Complex{});
  std::copy(fit.residual.begin() + static_cast<std::ptrdiff_t>(fit.band.first),
            fit.residual.begin() + static_cast<std::ptrdiff_t>(fit.band.last),
            fft.spectrum().begin() + static_cast<std::ptrdiff_t>(fit.band.first));
  fft.inverse();
  return {fft.signal().begin(), fft.signal().end()};
}

/// Whether a weaker candidate may be no more than the skirt of a stronger one.
bool in_skirt(const Candidate& weak, const Candidate& strong, double slowest) {
  const double width = slowest - weak.rate.real() - strong.rate.real();
  const double apart = weak.rate.imag() - strong.rate.imag();
  return weak.gain < 4 * strong.gain * width * width / (width * width + apart * apart);
}

/// Mean of what is around each bin, from its lowest fifth over 400 bins (some 60 that are
/// independent) or a third of an octave.
std::vector<double> clutter_of(std::span<const double> gains, std::size_t first, std::size_t last) {
  std::vector<double> clutter(gains.size(), 0);
  std::vector<double> part;
  for (std::size_t from = first; from < last;) {
    std::size_t to =
        std::max(from + 400, static_cast<std::size_t>(1.26 * static_cast<double>(from)));
    if (to + 400 > last) to = last + 1;
    part.assign(gains.begin() + static_cast<std::ptrdiff_t>(from),
                gains.begin() + static_cast<std::ptrdiff_t>(to));
    const auto fifth = part.begin() + static_cast<std::ptrdiff_t>(part.size() / 5);
    std::nth_element(part.begin(), fifth, part.end());
    // A fifth of what is distributed exponentially is below -ln(0.8) of its mean.
    const double mean = *fifth / 0.2231;
    for (std::size_t k = from; k < to; ++k) clutter[k] = mean;
    from = to;
  }
  return clutter;
}

/// Where the residual may hold a tone, by generalised likelihood ratio; strongest first.
/// @param max_clutter  what is stronger counts in any case
std::vector<Candidate> candidates(const ToneFit& fit, std::span<const double> signal,
                                  const ToneSearch& search, double max_clutter,
                                  Transforms& transforms) {
  const auto count = static_cast<double>(signal.size());
  std::vector<Candidate> all;
  std::vector<double> gains;
  const double slowest = 0.5 / count;
  for (double decay = slowest; decay < max_decay_rate / search.sample_rate; decay *= grid_ratio) {
    const std::size_t length =
        std::min(signal.size(), static_cast<std::size_t>(std::ceil(10 / decay)));
    if (length < 32) break;
    const std::size_t size = synth::signal::good_fft_size(2 * length);
    synth::signal::RealFft& fft = transforms.of(size);
    double squares = 0, weight = 1;
    const double factor = std::exp(-decay);
    for (std::size_t n = 0; n < length; ++n, weight *= factor) {
      fft.signal()[n] = weight * signal[n];
      squares += weight * weight;
    }
    std::fill(fft.signal().begin() + static_cast<std::ptrdiff_t>(length), fft.signal().end(), 0.0);
    fft.forward();
    // Twice the gain of log-likelihood at each bin.
    const double bins = count / static_cast<double>(size);  // of the fit for one of these
    const auto first = static_cast<std::size_t>(static_cast<double>(fit.band.first) / bins) + 1;
    const auto last = std::min(fft.bins() - 1,
                               static_cast<std::size_t>(static_cast<double>(fit.band.last) / bins));
    gains.assign(fft.bins(), 0);
    for (std::size_t k = first; k <= last; ++k) {
      const auto bin = static_cast<std::size_t>(static_cast<double>(k) * bins);
      const double noise = fit.noise[std::min(fit.noise.size() - 1, bin)];
      gains[k] = 2 * count * std::norm(fft.spectrum()[k]) / (noise * squares);
    }
    const std::vector<double> clutter = clutter_of(gains, first, last);
    for (std::size_t k = first + 1; k < last; ++k) {
      const auto bin = static_cast<std::size_t>(static_cast<double>(k) * bins);
      const double known = std::norm(fit.spectrum[bin] - fit.residual[bin]) / fit.noise[bin];
      const double threshold =
          std::max({new_tone, std::min(above_clutter * clutter[k], max_clutter),
                    model_error * (2 + count * decay) * known});
      if (gains[k] < threshold || gains[k] < gains[k - 1] || gains[k] <= gains[k + 1]) continue;
      const double omega =
          2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(size);
      all.push_back({{-decay, omega}, gains[k], threshold});
    }
  }
  std::sort(all.begin(), all.end(),
            [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
  std::vector<Candidate> kept;
  for (const Candidate& candidate : all) {
    const bool hidden = std::any_of(kept.begin(), kept.end(), [&](const Candidate& strong) {
      return in_skirt(candidate, strong, slowest);
    });
    if (!hidden) kept.push_back(candidate);
    if (kept.size() >= max_candidates) break;
  }
  return kept;
}

/// Tries what the residual may hold, the strongest first.
/// @return  whether there was any
bool add_tones(ToneFit& fit, std::span<const double> signal, const ToneSearch& search,
               double max_clutter, Transforms& transforms) {
  const std::size_t count = fit.grid->count();
  double strongest = 0;
  for (const Tone& tone : fit.tones) strongest = std::max(strongest, energy(tone, count));
  const double minimum = search.min_energy * strongest;
  bool any = false;
  for (const Candidate& candidate : candidates(fit, signal, search, max_clutter, transforms)) {
    if (fit.tones.size() >= search.max_tones) break;
    if (beside_tone(fit, candidate.rate)) continue;
    // A place on the grid shows less than the tone that is near it.
    const double threshold = std::max(new_tone, 0.5 * candidate.threshold);
    const ToneGain gain = gain_of(fit, {&candidate.rate, 1});
    if (gain.gain < 0.4 * threshold ||
        energy({gain.amplitudes[0], candidate.rate}, count) < minimum) {
      continue;
    }
    std::vector<Complex> rates = rates_around(fit, signal, candidate.rate);
    rates.push_back(candidate.rate);
    for (const Complex rate : rates) {
      if (beside_tone(fit, rate) || !try_tone(fit, rate, threshold)) continue;
      any = true;
      // At once, before the skirts of what is left of a pair are taken for tones.
      if (misfits(fit, fit.tones.size() - 1)) {
        try_pair(fit, fit.tones.size() - 1, signal_of(fit, transforms));
      }
    }
  }
  return any;
}

double chi_squared(const ToneFit& fit) {
  double sum = 0;
  for (std::size_t k = fit.band.first; k < fit.band.last; ++k) {
    sum += 2 * std::norm(fit.residual[k]) / fit.noise[k];
  }
  return sum;
}

std::vector<double> noise_of(const ToneFit& fit) {
  std::vector<double> noise = noise_floor(fit.residual, fit.band);
  double strongest = 0;
  for (const Tone& tone : fit.tones) {
    const Complex u = 1.0 - std::exp(tone.rate * static_cast<double>(fit.grid->count()));
    const double decay =
        std::max(std::abs(tone.rate.real()), 1 / static_cast<double>(fit.grid->count()));
    strongest = std::max(strongest, 0.25 * std::norm(tone.amplitude * u / decay));
  }
  for (std::size_t k = fit.band.first; k < fit.band.last; ++k) {
    strongest = std::max(strongest, std::norm(fit.residual[k]));
  }
  for (double& value : noise) value = std::max(value, dynamic_range * strongest);
  return noise;
}

double mean_log(std::span<const double> values, BinRange band) {
  double sum = 0;
  for (std::size_t k = band.first; k < band.last; ++k) sum += std::log(values[k]);
  return sum / static_cast<double>(band.size());
}

}  // namespace

std::size_t largest_fft_size(std::size_t count) {
  for (std::size_t size = count - count % 2; size >= 2; size -= 2) {
    if (synth::signal::good_fft_size(size) == size) return size;
  }
  return 0;
}

ToneFit find_tones(std::span<const double> samples, const ToneSearch& search) {
  Transforms transforms;
  const std::size_t count = samples.size();
  synth::signal::RealFft& fft = transforms.of(count);
  std::copy(samples.begin(), samples.end(), fft.signal().begin());
  fft.forward();

  ToneFit fit;
  fit.grid = std::make_shared<const ToneGrid>(count);
  fit.spectrum.assign(fft.spectrum().begin(), fft.spectrum().end());
  fit.residual = fit.spectrum;
  fit.fastest = 1.5 * max_decay_rate / search.sample_rate;
  const double per_hertz = static_cast<double>(count) / search.sample_rate;
  fit.band.first =
      std::max<std::size_t>(1, static_cast<std::size_t>(search.min_frequency * per_hertz));
  fit.band.last =
      std::min(fft.bins() - 1, static_cast<std::size_t>(search.max_frequency * per_hertz) + 1);
  if (fit.band.size() < 8) {
    fit.noise.assign(fit.residual.size(), 1);
    return fit;
  }
  fit.noise = noise_of(fit);
  // Before the tones are known, broad ones look like noise; the end of the signal is free of them.
  const std::vector<double> tail = tail_floor(samples, fit.band);
  for (std::size_t k = 0; k < tail.size(); ++k) {
    fit.noise[k] = std::max(std::min(fit.noise[k], tail[k]), 1e-3 * fit.noise[k]);
  }
  for (int round = 0; round < max_rounds && fit.tones.size() < search.max_tones; ++round) {
    const std::vector<double> signal = signal_of(fit, transforms);
    const std::size_t known = fit.tones.size();
    bool any = add_tones(fit, signal, search, std::numeric_limits<double>::infinity(), transforms);
    if (!any) any = add_tones(fit, signal, search, of_all * chi_squared(fit), transforms);
    refine_all(fit, 5, Fineness::few_bins, round < 2 ? 0 : known);
    fit.noise = noise_of(fit);
    prune(fit);
    for (std::size_t k = 0; k < fit.tones.size() && fit.tones.size() < search.max_tones; ++k) {
      if (misfits(fit, k) && try_pair(fit, k, signal_of(fit, transforms))) any = true;
    }
    if (!any) break;
  }
  // No pairs are looked for any more: what still grows goes.
  for (Tone& tone : fit.tones) tone.tried = 1;
  // What is not refined yet counts as noise, by which it is judged whether it is: again, then.
  bool pruned = true;
  for (int again = 0; again < 3; ++again) {
    refine_all(fit, 4, Fineness::all_bins);
    pruned = prune(fit);
    const double before = mean_log(fit.noise, fit.band);
    fit.noise = noise_of(fit);
    if (!pruned && before - mean_log(fit.noise, fit.band) < settled) break;
  }
  // What was taken out last has left neighbours that stood in for it.
  if (pruned) refine_all(fit, 4, Fineness::all_bins);
  return fit;
}

}  // namespace carillon::eval::features
