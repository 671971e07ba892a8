#include "eval/features/detail/sounding_end.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/numbers.hpp"
#include "eval/features/detail/noise_floor.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::eval::features {

namespace {

constexpr double energy_frame = 0.01;  ///< [s]
constexpr double min_length = 1;       ///< [s]
constexpr double heard_above = 1.5;    ///< energy of a frame
constexpr double line_above = 20;      ///< power over the noise's
constexpr std::size_t times_audible = 4;
constexpr double min_quiet = 0.1;  ///< [s]

/// Power spectrum by a Hann window in which a tone of amplitude 1 is a peak of 1.
std::vector<double> powers_of(std::span<const double> samples) {
  synth::signal::RealFft fft(synth::signal::good_fft_size(samples.size()));
  std::fill(fft.signal().begin(), fft.signal().end(), 0.0);
  const auto count = static_cast<double>(samples.size());
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const double place = (static_cast<double>(n) + 0.5) / count;
    const double weight = 1 - std::cos(2 * std::numbers::pi * place);
    fft.signal()[n] = weight * samples[n] * 2 / count;
  }
  fft.forward();
  std::vector<double> powers(fft.bins());
  for (std::size_t k = 0; k < powers.size(); ++k) powers[k] = std::norm(fft.spectrum()[k]);
  return powers;
}

/// Largest power around a place of a spectrum, as a fraction of half the sample rate.
double power_around(std::span<const double> powers, double place) {
  const double bin = place * static_cast<double>(powers.size() - 1);
  const auto first = static_cast<std::ptrdiff_t>(std::max(0.0, bin - 1.5));
  const auto last =
      std::min(static_cast<std::ptrdiff_t>(powers.size()), static_cast<std::ptrdiff_t>(bin + 2.5));
  return *std::max_element(powers.begin() + first, powers.begin() + last);
}

/// Whether lines of the sound are in its end.
bool has_lines(std::span<const double> end, std::span<const double> quiet, double sample_rate) {
  const std::vector<double> powers = powers_of(end);
  const BinRange band{1, powers.size() - 1};
  const std::vector<double> floor = noise_floor(std::span<const double>(powers), band);
  std::vector<double> before;
  if (static_cast<double>(quiet.size()) > min_quiet * sample_rate) {
    before = powers_of(quiet.last(std::min(quiet.size(), end.size())));
  }
  for (std::size_t k = band.first + 2; k + 2 < band.last; ++k) {
    if (powers[k] < line_above * floor[k]) continue;
    const double place = static_cast<double>(k) / static_cast<double>(powers.size() - 1);
    if (before.empty() || power_around(before, place) < 0.25 * powers[k]) return true;
  }
  return false;
}

}  // namespace

std::size_t sounding_end(std::span<const double> samples, std::span<const double> quiet,
                         double sample_rate) {
  const auto frame = static_cast<std::size_t>(energy_frame * sample_rate);
  const auto shortest = static_cast<std::size_t>(min_length * sample_rate);
  if (frame == 0 || samples.size() < 2 * shortest) return samples.size();
  std::vector<double> energies(samples.size() / frame, 0);
  for (std::size_t k = 0; k < energies.size(); ++k) {
    for (std::size_t n = k * frame + 1; n < (k + 1) * frame; ++n) {
      const double step = samples[n] - samples[n - 1];
      energies[k] += step * step;
    }
  }
  const double noise = core::median(
      {energies.end() - static_cast<std::ptrdiff_t>(energies.size() / 4), energies.end()});
  // The first of several frames in which nothing is left: noise has bursts of its own.
  constexpr std::size_t several = 5;
  std::size_t quiet_frames = 0, k = 0;
  while (k < energies.size() && quiet_frames < several) {
    quiet_frames = energies[k] < heard_above * noise ? quiet_frames + 1 : 0;
    ++k;
  }
  const std::size_t length = std::max(shortest, times_audible * k * frame);
  if (quiet_frames < several || 4 * length > 3 * samples.size()) return samples.size();
  return has_lines(samples.subspan(length), quiet, sample_rate) ? samples.size() : length;
}

}  // namespace carillon::eval::features
