#include "eval/features/detail/crowding.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace carillon::eval::features {

namespace {

constexpr double smoothing = 5;  // lines
/// Of the root of noise over signal: with it 95 % of drawn modes lie within two errors.
constexpr double hidden = 54;
constexpr double min_ratio = 1e-3;  // of noise over signal: what extraction itself leaves
constexpr double known = 0.99;      // of a decay rate: its error at most

double height_of(const Feature& mode) {
  return mode.amplitude / mode.decay_rate;
}

}  // namespace

double crowding(std::span<const Feature> features, std::size_t index) {
  const Feature& mode = features[index];
  double sum = 0;
  for (std::size_t k = 0; k < features.size(); ++k) {
    if (k == index) continue;
    // Half widths of both lines, and the distance [Hz].
    const double line = (mode.decay_rate + features[k].decay_rate) / (2 * std::numbers::pi);
    const double width = 0.5 * smoothing * line;
    const double away = features[k].frequency - mode.frequency;
    const double strength = std::min(1.0, height_of(features[k]) / height_of(mode));
    sum += strength * line / std::numbers::pi * width / (away * away + width * width);
  }
  return std::min(1.0, sum);
}

void widen_crowded(std::span<Feature> features) {
  std::vector<double> parts;  // of the half width
  for (std::size_t k = 0; k < features.size(); ++k) {
    const double ratio = std::max(min_ratio, std::pow(10, -features[k].snr / 20));
    parts.push_back(hidden * std::pow(crowding(features, k), 1.5) * std::sqrt(ratio));
  }
  for (std::size_t k = 0; k < features.size(); ++k) {
    Feature& mode = features[k];
    const double shift = parts[k] * mode.decay_rate;
    mode.decay_rate_error = std::min(std::hypot(mode.decay_rate_error, shift),
                                     std::max(mode.decay_rate_error, known * mode.decay_rate));
    mode.frequency_error = std::hypot(mode.frequency_error, shift / (2 * std::numbers::pi));
    mode.amplitude_error = std::hypot(mode.amplitude_error, parts[k] * mode.amplitude);
  }
}

}  // namespace carillon::eval::features
