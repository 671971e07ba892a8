#include "synth/room/octave_filters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::synth::room {

namespace {

constexpr double reflection_half_width =
    1.0 / 6;                                  ///< of the crossings of reflection filters [octaves]
constexpr double reflection_seconds = 0.046;  ///< 2048 samples at 44.1 kHz
constexpr double range = 1e-3;                ///< least gain against the loudest octave
constexpr int points = 24;                    ///< of each octave's mean
constexpr double correction = 0.7;            ///< most that an exponent is moved [Np], 6 dB

/// exp(z) for many z; std::exp(complex) guards against cases that do not occur here.
std::complex<double> exponential(double re, double im) {
  const double size = std::exp(re);
  return {size * std::cos(im), size * std::sin(im)};
}

}  // namespace

double crossing(double frequency, double edge, double half_width) {
  if (!(frequency > 0)) return 0;
  const double x = std::log2(frequency / edge) / (2 * half_width) + 0.5;
  return 0.5 - 0.5 * std::cos(std::numbers::pi * std::clamp(x, 0.0, 1.0));
}

OctaveValues octave_fractions(double frequency, std::size_t octaves, double half_width) {
  OctaveValues fractions{};
  double left = 1;  // of the octaves from b on
  for (std::size_t b = 0; b + 1 < octaves; ++b) {
    const double above = crossing(frequency, upper_edge(b), half_width);
    fractions[b] = left * (1 - above);
    left *= above;
  }
  fractions[octaves - 1] = left;
  return fractions;
}

ReflectionFilters::ReflectionFilters(double sample_rate) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw core::InputError(fmt::format("a room at a sample rate of {} Hz", sample_rate));
  }
  octaves_ = octaves_below_nyquist(sample_rate);
  size_ = signal::good_fft_size(std::max<std::size_t>(
      256, static_cast<std::size_t>(std::ceil(reflection_seconds * sample_rate))));
  signal::RealFft fft(size_);
  for (std::size_t b = 0; b < octaves_; ++b) {
    for (std::size_t k = 0; k < fft.bins(); ++k) {
      const double f = static_cast<double>(k) * sample_rate / static_cast<double>(size_);
      fft.spectrum()[k] = octave_fractions(f, octaves_, reflection_half_width)[b];
    }
    signal::to_minimum_phase(fft);
    log_spectra_[b].assign(fft.spectrum().begin(), fft.spectrum().end());
    const double low = lower_edge(b);
    const double high = std::min(upper_edge(b), sample_rate / 2);
    for (int i = 0; i < points; ++i) {
      points_.push_back({b, octave_fractions(low + (high - low) * (i + 0.5) / points, octaves_,
                                             reflection_half_width)});
    }
  }
}

OctaveValues ReflectionFilters::exponents(const OctaveValues& gains) const {
  double loudest = 0;
  for (std::size_t b = 0; b < octaves_; ++b) loudest = std::max(loudest, gains[b]);
  OctaveValues wanted{};
  for (std::size_t b = 0; b < octaves_; ++b) {
    wanted[b] = std::log(std::max(gains[b], range * loudest));
  }
  // Neighbours reach into an octave across its edges; what they add or take there is made good.
  OctaveValues x = wanted;
  for (int round = 0; round < 5; ++round) {
    OctaveValues energy{};
    for (const Point& point : points_) {
      double log_gain = 0;
      for (std::size_t b = 0; b < octaves_; ++b) log_gain += point.fractions[b] * x[b];
      energy[point.octave] += std::exp(2 * log_gain) / points;
    }
    for (std::size_t b = 0; b < octaves_; ++b) {
      x[b] = std::clamp(x[b] + wanted[b] - 0.5 * std::log(energy[b]), wanted[b] - correction,
                        wanted[b] + correction);
    }
  }
  return x;
}

void ReflectionFilters::apply(const OctaveValues& gains,
                              std::span<std::complex<double>> spectrum) const {
  const double loudest = *std::max_element(gains.begin(), gains.begin() + octaves_);
  if (!(loudest > 0)) {
    std::fill(spectrum.begin(), spectrum.end(), 0.0);
    return;
  }
  OctaveValues relative{};
  for (std::size_t b = 0; b < octaves_; ++b) relative[b] = gains[b] / loudest;
  const OctaveValues x = exponents(relative);
  for (std::size_t k = 0; k < spectrum.size(); ++k) {
    double re = 0;
    double im = 0;
    for (std::size_t b = 0; b < octaves_; ++b) {
      re += x[b] * log_spectra_[b][k].real();
      im += x[b] * log_spectra_[b][k].imag();
    }
    const auto h = loudest * exponential(re, im);
    spectrum[k] = {spectrum[k].real() * h.real() - spectrum[k].imag() * h.imag(),
                   spectrum[k].real() * h.imag() + spectrum[k].imag() * h.real()};
  }
}

}  // namespace carillon::synth::room
