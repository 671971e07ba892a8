#include "tests/eval/struck_bodies.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/random.hpp"

namespace carillon::test {

namespace {

constexpr double pi = std::numbers::pi;

/// Sorted by eigenvalue, the lowest `count`.
eval::material::StruckModes sorted(std::vector<std::array<double, 2>> modes,
                                   double specific_modulus, std::size_t count) {
  std::sort(modes.begin(), modes.end());
  modes.resize(std::min(count, modes.size()));
  eval::material::StruckModes struck;
  struck.specific_modulus = specific_modulus;
  struck.complete_to_hz = std::sqrt(modes.back()[0]) / (2 * pi);
  for (const auto& [eigenvalue, gain] : modes) {
    struck.eigenvalues.push_back(eigenvalue);
    struck.gains.push_back(gain);
  }
  return struck;
}

}  // namespace

eval::material::StruckModes free_bar(double specific_modulus, double length, double thickness,
                                     std::size_t count) {
  std::vector<std::array<double, 2>> modes;
  const double at = 0.13;  // of the length, from the middle
  for (std::size_t n = 1; n <= count; ++n) {
    // cosh k cos k = 1: k is near (n + 1/2) pi, and nearer with every mode.
    double k = (static_cast<double>(n) + 0.5) * pi;
    for (int i = 0; i < 50; ++i) {
      k = (static_cast<double>(n) + 0.5) * pi + (n % 2 == 1 ? 1 : -1) * std::asin(1 / std::cosh(k));
    }
    const double shape =
        n % 2 == 1 ? std::cos(k * at) + std::cos(k / 2) / std::cosh(k / 2) * std::cosh(k * at)
                   : std::sin(k * at) + std::sin(k / 2) / std::sinh(k / 2) * std::sinh(k * at);
    modes.push_back(
        {specific_modulus * thickness * thickness / 12 * std::pow(k / length, 4), shape * shape});
  }
  return sorted(std::move(modes), specific_modulus, count);
}

eval::material::StruckModes hinged_plate(double specific_modulus, double length, double width,
                                         double thickness, std::size_t count) {
  std::vector<std::array<double, 2>> modes;
  for (int m = 1; m <= 30; ++m) {
    for (int n = 1; n <= 30; ++n) {
      const double wave = pi * pi * (m * m / (length * length) + n * n / (width * width));
      const double shape = std::sin(0.37 * pi * m) * std::sin(0.23 * pi * n);
      modes.push_back({specific_modulus * thickness * thickness / (12 * (1 - 0.0625)) * wave * wave,
                       shape * shape});
    }
  }
  return sorted(std::move(modes), specific_modulus, count);
}

eval::material::StruckModes free_ring(double specific_modulus, double radius, double thickness,
                                      std::size_t count) {
  std::vector<std::array<double, 2>> modes;
  for (std::size_t i = 2; i < count + 2; ++i) {
    const auto n = static_cast<double>(i);
    const double form = n * n * (n * n - 1) * (n * n - 1) / (n * n + 1);
    modes.push_back({specific_modulus * thickness * thickness / (12 * std::pow(radius, 4)) * form,
                     n * n / (n * n + 1)});
  }
  return sorted(std::move(modes), specific_modulus, count);
}

Recorded record(const std::vector<eval::features::Feature>& tones, const RecordedOptions& options) {
  core::RandomStream random(options.seed, 0, "test.recorded");
  Recorded recorded;
  eval::features::FeatureSet& set = recorded.set;
  const auto count = static_cast<std::size_t>(options.seconds * options.sample_rate);
  recorded.samples.assign(count, 0);
  // Every tone draws alike, so that the rest stay the same when some are left out.
  for (const eval::features::Feature& tone : tones) {
    const double phase = options.random_phases ? random.uniform(0, 2 * pi) : 0;
    if (random.uniform() < options.missing) continue;
    for (std::size_t i = 0; i < count; ++i) {
      const double t = static_cast<double>(i) / options.sample_rate;
      recorded.samples[i] += tone.amplitude * std::exp(-tone.decay_rate * t) *
                             std::cos(2 * pi * tone.frequency * t + phase);
    }
    set.features.push_back(tone);
    set.features.back().phase = phase;
  }
  double power = 0;
  for (const double x : recorded.samples) power += x * x / static_cast<double>(count);
  const double noise = std::sqrt(power * std::pow(10, -options.snr / 10));
  for (std::size_t i = 0; i < count; ++i) {
    set.residual.push_back(noise * random.normal());
    recorded.samples[i] += set.residual.back();
  }
  set.sample_rate = options.sample_rate;
  set.end = options.seconds;
  set.explained = 1;
  return recorded;
}

}  // namespace carillon::test
