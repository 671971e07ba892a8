#include "eval/features/detail/noise_floor.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "synth/signal/real_fft.hpp"

namespace carillon::eval::features {

namespace {

constexpr double octave_fraction = 1.0 / 6;
constexpr std::size_t min_bins = 48;

/// Medians of power over neighbouring bins: where, and the mean of the noise that has this median.
struct Floor {
  std::vector<double> place;  ///< of a range's middle, as fraction of half the sample rate
  std::vector<double> log_power;
};

Floor floor_of(std::span<const double> power, BinRange band) {
  Floor floor;
  std::vector<double> part;
  const double growth = std::exp2(octave_fraction);
  for (std::size_t first = band.first; first < band.last;) {
    std::size_t last =
        std::max(first + min_bins, static_cast<std::size_t>(static_cast<double>(first) * growth));
    if (last + min_bins > band.last) last = band.last;
    part.assign(power.begin() + static_cast<std::ptrdiff_t>(first),
                power.begin() + static_cast<std::ptrdiff_t>(last));
    const auto middle = part.begin() + static_cast<std::ptrdiff_t>(part.size() / 2);
    std::nth_element(part.begin(), middle, part.end());
    floor.place.push_back(0.5 * static_cast<double>(first + last - 1) /
                          static_cast<double>(power.size() - 1));
    // Power of Gaussian noise in a bin is exponential: its median is ln 2 of its mean.
    floor.log_power.push_back(std::log(std::max(*middle / std::numbers::ln2, 1e-300)));
    first = last;
  }
  return floor;
}

std::vector<double> spread(const Floor& floor, std::size_t bins, double factor) {
  std::vector<double> power(bins);
  std::size_t at = 0;
  for (std::size_t k = 0; k < bins; ++k) {
    const double place = static_cast<double>(k) / static_cast<double>(bins - 1);
    while (at + 2 < floor.place.size() && floor.place[at + 1] < place) ++at;
    double value = floor.log_power[at];
    if (at + 1 < floor.place.size()) {
      const double fraction =
          std::clamp((place - floor.place[at]) / (floor.place[at + 1] - floor.place[at]), 0.0, 1.0);
      value += fraction * (floor.log_power[at + 1] - value);
    }
    power[k] = factor * std::exp(value);
  }
  return power;
}

}  // namespace

std::vector<double> noise_floor(std::span<const std::complex<double>> spectrum, BinRange band) {
  std::vector<double> power(spectrum.size());
  for (std::size_t k = 0; k < power.size(); ++k) power[k] = std::norm(spectrum[k]);
  return noise_floor(std::span<const double>(power), band);
}

std::vector<double> noise_floor(std::span<const double> powers, BinRange band) {
  return spread(floor_of(powers, band), powers.size(), 1);
}

std::vector<double> tail_floor(std::span<const double> samples, BinRange band) {
  const std::size_t length = std::max<std::size_t>(2, samples.size() / 4);
  const std::size_t start = samples.size() - length;
  synth::signal::RealFft fft(synth::signal::good_fft_size(length));
  double squares = 0;
  std::fill(fft.signal().begin(), fft.signal().end(), 0.0);
  for (std::size_t n = 0; n < length; ++n) {
    const double w = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(n) + 0.5) /
                                          static_cast<double>(length));
    squares += w * w;
    fft.signal()[n] = w * samples[start + n];
  }
  fft.forward();
  std::vector<double> power(fft.bins());
  for (std::size_t k = 0; k < power.size(); ++k) power[k] = std::norm(fft.spectrum()[k]);
  const std::size_t bins = samples.size() / 2 + 1;
  const double scale = static_cast<double>(power.size() - 1) / static_cast<double>(bins - 1);
  const BinRange own{
      std::max<std::size_t>(1, static_cast<std::size_t>(scale * static_cast<double>(band.first))),
      std::min(power.size(), static_cast<std::size_t>(scale * static_cast<double>(band.last)) + 1)};
  return spread(floor_of(power, own), bins, static_cast<double>(samples.size()) / squares);
}

}  // namespace carillon::eval::features
