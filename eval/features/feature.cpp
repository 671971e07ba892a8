#include "eval/features/feature.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace carillon::eval::features {

double eigenvalue(const Feature& feature) {
  const double omega = 2 * std::numbers::pi * feature.frequency;
  return omega * omega + feature.decay_rate * feature.decay_rate;
}

double room_decay_rate(std::span<const double> rt60, double frequency) {
  constexpr double first_octave = 125;
  const double octave = std::round(std::log2(frequency / first_octave));
  const double last = static_cast<double>(rt60.size() - 1);
  return std::log(1000.0) / rt60[static_cast<std::size_t>(std::clamp(octave, 0.0, last))];
}

bool reverberates(std::span<const double> rt60) {
  return std::any_of(rt60.begin(), rt60.end(), [](double time) { return time > 0; });
}

}  // namespace carillon::eval::features
