#include "eval/perception/compare_sounds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/material/loudness.hpp"
#include "synth/signal/resample.hpp"

namespace carillon::eval::perception {

namespace {

using core::nan;

/// From the onset to the next strike or the end, without a constant offset, at a rate.
std::vector<double> ringing(const HeardSound& sound, double rate) {
  const double own = sound.set.sample_rate;
  if (!(own > 0)) throw core::InputError("the sample rate must be positive");
  const auto place = [&](double time) {
    return std::min(sound.samples.size(),
                    static_cast<std::size_t>(std::lround(std::max(0.0, time) * own)));
  };
  const std::size_t begin = place(sound.set.onset);
  const std::size_t end = sound.set.nothing.empty() ? place(sound.set.end) : sound.samples.size();
  if (begin >= end) throw core::InputError("no samples after the onset to compare");
  std::vector<double> part(sound.samples.begin() + static_cast<std::ptrdiff_t>(begin),
                           sound.samples.begin() + static_cast<std::ptrdiff_t>(end));
  const double offset =
      std::accumulate(part.begin(), part.end(), 0.0) / static_cast<double>(part.size());
  for (double& sample : part) sample -= offset;
  return synth::signal::resample(part, own, rate);
}

double sum_of_squares(const std::vector<double>& values) {
  return std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
}

double loudest_frame(const std::vector<double>& loudness, const material::SpectrogramGrid& grid) {
  double loudest = 0;
  for (std::size_t m = 0; m < grid.frames; ++m) {
    const auto begin = loudness.begin() + static_cast<std::ptrdiff_t>(m * grid.bands);
    // Bands are one Bark wide.
    loudest = std::max(
        loudest, std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(grid.bands), 0.0));
  }
  return loudest;
}

LoudnessDifference compare_loudness(std::span<const double> reference,
                                    std::span<const double> other, double rate,
                                    double loudest_level) {
  const material::SpectrogramGrid grid = material::make_grid(reference.size(), rate, 0);
  const material::BandPowers first = material::band_powers(reference, grid),
                             second = material::band_powers(other, grid);
  const double loudest = std::max(*std::max_element(first.begin(), first.end()),
                                  *std::max_element(second.begin(), second.end()));
  material::LoudnessScale scale;
  scale.unit_level = loudest_level - core::decibels(std::max(loudest, 1e-300));
  const auto of_reference = material::specific_loudness(first, grid, scale);
  const auto of_other = material::specific_loudness(second, grid, scale);
  double squares = 0;
  for (std::size_t i = 0; i < of_reference.size(); ++i) {
    squares += (of_reference[i] - of_other[i]) * (of_reference[i] - of_other[i]);
  }
  const double own = 0.5 * (sum_of_squares(of_reference) + sum_of_squares(of_other));
  return {std::sqrt(squares / static_cast<double>(of_reference.size())),
          own > 0 ? std::sqrt(squares / own) : nan, loudest_frame(of_reference, grid),
          loudest_frame(of_other, grid)};
}

}  // namespace

SoundComparison compare_sounds(const HeardSound& reference, const HeardSound& other,
                               const SoundComparisonOptions& options) {
  if (!(options.loudest_level >= 0 && options.loudest_level <= 140)) {
    throw core::InputError(
        fmt::format("--loudest-level: {} dB lies outside 0 to 140 dB", options.loudest_level));
  }
  if (!(options.modes.widest > 0)) throw core::InputError("--widest: it must be positive");
  SoundComparison comparison;
  comparison.sample_rate = std::min(reference.set.sample_rate, other.set.sample_rate);
  std::vector<double> first = ringing(reference, comparison.sample_rate);
  std::vector<double> second = ringing(other, comparison.sample_rate);
  const std::size_t count = std::min(first.size(), second.size());
  if (count == 0) throw core::InputError("no samples after the onset to compare");
  first.resize(count);
  second.resize(count);
  comparison.seconds = static_cast<double>(count) / comparison.sample_rate;
  comparison.level = core::decibels(sum_of_squares(second) / sum_of_squares(first));
  ModeComparisonOptions modes = options.modes;
  modes.from = std::max(
      {modes.from, reference.set.begin - reference.set.onset, other.set.begin - other.set.onset});
  comparison.modes = compare_modes(reference.set.features, other.set.features, modes);
  comparison.loudness =
      compare_loudness(first, second, comparison.sample_rate, options.loudest_level);
  comparison.spectra = spectral_distance(first, second);
  return comparison;
}

}  // namespace carillon::eval::perception
