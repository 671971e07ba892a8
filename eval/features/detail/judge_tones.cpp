#include "eval/features/detail/judge_tones.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

namespace carillon::eval::features {

namespace {

using Complex = std::complex<double>;

constexpr double later = 1.5;           ///< times 1 / d
constexpr double until = 7.5;           ///< times 1 / d: nothing is left
constexpr double same_amplitude = 0.5;  ///< as a fraction
constexpr double errors = 3;
constexpr double min_quiet = 0.05;  ///< before a strike, in which a hum shows [s]
constexpr double min_cycles = 8;

/// Amplitude of a tone in a signal; none if the signal is too short for it.
std::optional<double> amplitude_in(std::span<const double> signal, double frequency,
                                   double sample_rate) {
  const auto count = static_cast<double>(signal.size());
  if (count < min_quiet * sample_rate || count * frequency < min_cycles * sample_rate) {
    return std::nullopt;
  }
  Complex sum = 0;
  double weights = 0;
  const double omega = 2 * std::numbers::pi * frequency / sample_rate;
  for (std::size_t n = 0; n < signal.size(); ++n) {
    const double place = (static_cast<double>(n) + 0.5) / count;
    const double weight = 1 - std::cos(2 * std::numbers::pi * place);  // Hann
    sum += weight * signal[n] * std::polar(1.0, -omega * static_cast<double>(n));
    weights += weight;
  }
  return 2 * std::abs(sum) / weights;
}

/// Above the twentieth multiple of either, where none is strong and all lie within what mains keep
/// of any frequency, nothing is one.
bool at_mains_harmonic(double frequency) {
  constexpr double highest = 1200;
  if (frequency > highest) return false;
  for (const double mains : {50.0, 60.0}) {
    const double harmonic = std::max(1.0, std::round(frequency / mains));
    if (std::abs(frequency - harmonic * mains) < 0.003 * frequency + 0.1) return true;
  }
  return false;
}

}  // namespace

ToneJudgement judge(const ToneFit& fit, std::size_t index, std::span<const double> residual) {
  const Tone& tone = fit.tones[index];
  const double decay = std::max(-tone.rate.real(), 1e-12);
  const auto count = static_cast<double>(residual.size());
  const auto from = static_cast<std::size_t>(std::min(later / decay, 0.5 * count));
  const auto to = static_cast<std::size_t>(std::min(until / decay, count));
  // Least squares of the residual by the tone's two quadratures.
  double aa = 0, ab = 0, bb = 0, ra = 0, rb = 0;
  const Complex turn = std::exp(tone.rate);
  Complex value = tone.amplitude * std::exp(tone.rate * static_cast<double>(from));
  for (std::size_t n = from; n < to; ++n, value *= turn) {
    aa += value.real() * value.real();
    ab -= value.real() * value.imag();
    bb += value.imag() * value.imag();
    ra += value.real() * residual[n];
    rb -= value.imag() * residual[n];
  }
  const double determinant = aa * bb - ab * ab;
  ToneJudgement judgement;
  if (!(determinant > 1e-6 * aa * bb)) return judgement;
  const Complex change((bb * ra - ab * rb) / determinant, (aa * rb - ab * ra) / determinant);
  const double bin = tone.rate.imag() * count / (2 * std::numbers::pi);
  const double noise =
      fit.noise[std::min(fit.noise.size() - 1, static_cast<std::size_t>(bin))] / count;
  const double variance = 2 * noise / (0.5 * (aa + bb));
  judgement.drift = std::sqrt(std::max(0.0, std::norm(change) - 2 * variance));
  judgement.is_mode = std::abs(change) < std::max(same_amplitude, errors * std::sqrt(variance));
  return judgement;
}

std::vector<std::size_t> indistinct(const ToneFit& fit) {
  const auto length = static_cast<double>(fit.grid->count());
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < fit.tones.size(); ++k) {
    const Tone& tone = fit.tones[k];
    const double own = energy(tone, fit.grid->count());
    const bool beside = std::any_of(fit.tones.begin(), fit.tones.end(), [&](const Tone& other) {
      const double line = 1 / length + std::abs(other.rate.real()) + std::abs(tone.rate.real());
      return &other != &tone && std::abs(other.rate.imag() - tone.rate.imag()) < line &&
             energy(other, fit.grid->count()) >= own;
    });
    if (!beside) continue;
    const ToneErrors errors = errors_of(fit, k);
    if (std::sqrt(errors.misfit) * errors.amplitude_real > std::abs(tone.amplitude)) {
      found.push_back(k);
    }
  }
  return found;
}

std::vector<bool> depending_on(const ToneFit& fit, std::vector<bool> left_out) {
  constexpr double share = 0.5;
  const std::size_t count = fit.grid->count();
  for (bool any = true; any;) {
    any = false;
    for (std::size_t k = 0; k < fit.tones.size(); ++k) {
      if (left_out[k]) continue;
      double sum = 0;
      for (std::size_t j = 0; j < fit.tones.size(); ++j) {
        if (left_out[j]) sum += product(fit.tones[k], fit.tones[j], count);
      }
      if (sum > -share * energy(fit.tones[k], count)) continue;
      left_out[k] = any = true;
    }
  }
  return left_out;
}

Steadiness steadiness(const SlowTone& tone, std::span<const double> quiet, double sample_rate) {
  if (const auto before = amplitude_in(quiet, tone.frequency, sample_rate)) {
    if (*before > 0.5 * tone.amplitude) return Steadiness::hum;
  } else {
    const double lost = std::abs(tone.decay_rate) * tone.duration;
    const bool steady =
        lost < 0.05 || (lost < 0.5 && std::abs(tone.decay_rate) < 3 * tone.decay_rate_error);
    if (steady && at_mains_harmonic(tone.frequency)) return Steadiness::hum;
  }
  if (std::abs(tone.decay_rate) * tone.duration < 0.02) return Steadiness::hum;
  return tone.decay_rate > 0 ? Steadiness::mode : Steadiness::neither;
}

}  // namespace carillon::eval::features
