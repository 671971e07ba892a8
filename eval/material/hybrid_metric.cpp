#include "eval/material/hybrid_metric.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::eval::material {

namespace {

/// Match ratios below count as this, so that every candidate has a finite metric.
constexpr double min_match = 1e-3;
/// What a candidate whose damping is negative everywhere pays.
constexpr double negative_penalty = 10;
/// The least range of levels among features [dB], and what is added to that of the recording's.
constexpr double narrowest = 20;
constexpr double margin = 3;
constexpr double lowest_frequency = 20;
constexpr double highest_frequency = 20000;

/// Median power of each band over frames: a strike's own sound in some frames does not raise it.
std::vector<double> steady_power(std::span<const double> samples, const SpectrogramGrid& grid) {
  const BandPowers powers = band_powers(samples, grid);
  std::vector<double> steady(grid.bands);
  std::vector<double> column(grid.frames);
  for (std::size_t z = 0; z < grid.bands; ++z) {
    for (std::size_t m = 0; m < grid.frames; ++m) column[m] = powers[m * grid.bands + z];
    const auto middle = column.begin() + static_cast<std::ptrdiff_t>(grid.frames / 2);
    std::nth_element(column.begin(), middle, column.end());
    steady[z] = *middle;
  }
  return steady;
}

std::vector<double> background_of(const features::FeatureSet& set, const SpectrogramGrid& grid) {
  std::vector<double> background(grid.bands, 0.0);
  if (!set.residual.empty()) background = steady_power(set.residual, grid);
  std::vector<features::Feature> hums;
  for (const features::Hum& hum : set.hums) {
    features::Feature tone;
    tone.frequency = hum.frequency;
    tone.amplitude = hum.amplitude;
    hums.push_back(tone);
  }
  SpectrogramGrid one = grid;
  one.frames = 1;
  const BandPowers powers = band_powers(hums, one);
  for (std::size_t z = 0; z < grid.bands; ++z) background[z] += powers[z];
  return background;
}

/// What is weaker than the weakest feature would not have been found in the recording: modes that
/// weak are not missed [dB].
double range_of(std::span<const features::Feature> features, double widest) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const features::Feature& feature : features) {
    const double energy = audible_energy(feature);
    low = std::min(low, energy);
    high = std::max(high, energy);
  }
  return std::clamp(high - low + margin, narrowest, widest);
}

}  // namespace

Reference make_reference(std::span<const double> samples, const features::FeatureSet& set,
                         const MetricOptions& options) {
  if (set.features.empty()) {
    throw core::InputError(fmt::format("no modes can be heard in the recording{}{}",
                                       set.nothing.empty() ? "" : ": ", set.nothing),
                           "a material is estimated from a struck object's ringing");
  }
  const auto first = static_cast<std::size_t>(std::max(0.0, set.begin) * set.sample_rate + 0.5);
  const auto last = std::min(
      samples.size(), static_cast<std::size_t>(std::max(0.0, set.end) * set.sample_rate + 0.5));
  if (first >= last) {
    throw core::InputError(
        fmt::format("the features lie between {} s and {} s of a recording of "
                    "{} s",
                    set.begin, set.end, static_cast<double>(samples.size()) / set.sample_rate));
  }
  Reference reference;
  reference.options = options;
  reference.grid = make_grid(last - first, set.sample_rate, set.begin - set.onset);
  reference.low = lowest_frequency;
  reference.high = std::min(highest_frequency, 0.475 * set.sample_rate);
  // A constant offset is not heard, but its leakage would be in the lowest bands.
  std::vector<double> clip(samples.begin() + static_cast<std::ptrdiff_t>(first),
                           samples.begin() + static_cast<std::ptrdiff_t>(last));
  const double offset =
      std::accumulate(clip.begin(), clip.end(), 0.0) / static_cast<double>(clip.size());
  for (double& sample : clip) sample -= offset;
  const BandPowers powers = band_powers(clip, reference.grid);
  const double loudest = *std::max_element(powers.begin(), powers.end());
  reference.loudness_scale.unit_level =
      options.loudest_level - core::decibels(std::max(loudest, 1e-300));
  // The recording's own background is in its powers already.
  reference.loudness = specific_loudness(powers, reference.grid, reference.loudness_scale);
  reference.loudness_scale.background = background_of(set, reference.grid);
  for (const double sone : reference.loudness) reference.loudness_squared += sone * sone;
  if (!(reference.loudness_squared > 0)) {
    throw core::InputError("nothing of the recording can be heard between 20 Hz and 20 kHz");
  }
  reference.options.match.range = range_of(set.features, options.match.range);
  reference.places = places_of(set.features, reference.options.match);
  return reference;
}

double match_ratio_product(const Reference& reference, const HeardCandidate& candidate) {
  const MatchScale& scale = reference.options.match;
  const std::vector<FeaturePlace> places = places_of(candidate.tones, scale);
  return match_ratio(reference.places, places, scale) *
         match_ratio(places, reference.places, scale) / (1 + negative_penalty * candidate.negative);
}

MetricValue hybrid_metric(const Reference& reference, const HeardCandidate& candidate) {
  const MetricOptions& options = reference.options;
  const std::vector<FeaturePlace> places = places_of(candidate.tones, options.match);
  MetricValue value;
  value.recording_match = match_ratio(reference.places, places, options.match);
  value.candidate_match = match_ratio(places, reference.places, options.match);
  const std::vector<double> loudness = specific_loudness(
      band_powers(candidate.tones, reference.grid), reference.grid, reference.loudness_scale);
  double sum = 0;
  for (std::size_t i = 0; i < loudness.size(); ++i) {
    const double difference = loudness[i] - reference.loudness[i];
    sum += difference * difference;
  }
  value.psychoacoustic = sum / reference.loudness_squared;
  value.metric =
      (value.psychoacoustic + options.min_difference) /
      (std::max(value.recording_match, min_match) * std::max(value.candidate_match, min_match)) *
      (1 + negative_penalty * candidate.negative);
  return value;
}

}  // namespace carillon::eval::material
