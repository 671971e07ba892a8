#pragma once

#include <fftw3.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>

namespace carillon::synth {

/// Power spectrum by Welch's method: Hann windows, half overlapping, one value per
/// rate / window [Hz]. Its scale is arbitrary.
inline std::vector<double> welch(std::span<const double> samples, std::size_t window) {
  std::vector<double> block(window), power(window / 2 + 1, 0.0);
  std::vector<fftw_complex> spectrum(window / 2 + 1);
  const fftw_plan plan =
      fftw_plan_dft_r2c_1d(static_cast<int>(window), block.data(), spectrum.data(), FFTW_ESTIMATE);
  for (std::size_t begin = 0; begin + window <= samples.size(); begin += window / 2) {
    for (std::size_t i = 0; i < window; ++i) {
      const double turn =
          2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(window);
      block[i] = samples[begin + i] * (0.5 - 0.5 * std::cos(turn));
    }
    fftw_execute(plan);
    for (std::size_t k = 0; k < power.size(); ++k) {
      power[k] += spectrum[k][0] * spectrum[k][0] + spectrum[k][1] * spectrum[k][1];
    }
  }
  fftw_destroy_plan(plan);
  return power;
}

/// Mean of a spectrum from `low` to `high` [Hz], in dB.
inline double band_level(const std::vector<double>& power, double bin, double low, double high) {
  double sum = 0;
  int count = 0;
  for (std::size_t k = 1; k < power.size(); ++k) {
    const double frequency = static_cast<double>(k) * bin;
    if (frequency < low || frequency >= high) continue;
    sum += power[k];
    ++count;
  }
  return 10 * std::log10(sum / count);
}

/// Level at one frequency [dB] by correlation with a sine and a cosine under a Blackman-Harris
/// window (side lobes below -92 dB): 0 for a sine of amplitude 1.
inline double tone_level(std::span<const double> samples, double frequency, double rate) {
  double re = 0, im = 0, sum = 0;
  const auto count = static_cast<double>(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double n = static_cast<double>(i);
    const double t = 2 * std::numbers::pi * n / count;
    const double window =
        0.35875 - 0.48829 * std::cos(t) + 0.14128 * std::cos(2 * t) - 0.01168 * std::cos(3 * t);
    const double turn = 2 * std::numbers::pi * frequency * n / rate;
    re += window * samples[i] * std::cos(turn);
    im += window * samples[i] * std::sin(turn);
    sum += window;
  }
  return 20 * std::log10(2 * std::hypot(re, im) / sum);
}

}  // namespace carillon::synth
