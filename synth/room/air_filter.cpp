#include "synth/room/air_filter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::synth::room {

namespace {

constexpr double filter_seconds = 0.046;  ///< 2048 samples at 44.1 kHz
constexpr double maximum = 120;           ///< [dB]

}  // namespace

double air_loss(double frequency, double distance, const Air& air) {
  return std::min(maximum, 10 / std::numbers::ln10 * air_absorption(frequency, air) * distance);
}

std::vector<double> air_response(double distance, const Air& air, double sample_rate) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate) || !(distance >= 0) ||
      !std::isfinite(distance)) {
    throw core::InputError(fmt::format("sound over {} m of air at {} Hz: both must be positive",
                                       distance, sample_rate));
  }
  // Losses grow with frequency.
  if (air_loss(sample_rate / 2, distance, air) < min_air_loss) return {};
  const std::size_t size = signal::good_fft_size(std::max<std::size_t>(
      256, static_cast<std::size_t>(std::ceil(filter_seconds * sample_rate))));
  signal::RealFft fft(size);
  for (std::size_t k = 0; k < fft.bins(); ++k) {
    const double f = static_cast<double>(k) * sample_rate / static_cast<double>(size);
    fft.spectrum()[k] = k == 0 ? 0.0 : -std::numbers::ln10 / 20 * air_loss(f, distance, air);
  }
  signal::to_minimum_phase(fft);
  for (std::complex<double>& value : fft.spectrum()) value = std::exp(value);
  fft.inverse();
  return {fft.signal().begin(), fft.signal().end()};
}

}  // namespace carillon::synth::room
