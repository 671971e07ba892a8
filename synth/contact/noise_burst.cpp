#include "synth/contact/noise_burst.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace carillon::synth::contact {

namespace {

/// The filter rings on after the burst; it is followed down to this share (-120 dB).
constexpr double filter_tail = 1e-6;

void check_part(double value, const char* what) {
  if (!(value >= 0 && value <= 1)) {
    throw core::InputError(
        fmt::format("noise burst: {} must lie between 0 and 1, not {}", what, value));
  }
}

/// Third-order Butterworth low-pass by the bilinear transform with the cut-off kept in place:
/// first-order section 1 / (s + 1), second-order 1 / (s^2 + s + 1).
void low_pass(std::vector<double>& samples, double cutoff, double sample_rate) {
  const double k = std::tan(std::numbers::pi * cutoff / sample_rate);
  double x1 = 0, x2 = 0, y1 = 0;
  for (double& sample : samples) {
    const double x = sample;
    sample = (k * (x + x1) + (1 - k) * y1) / (1 + k);
    x1 = x;
    y1 = sample;
  }
  x1 = x2 = y1 = 0;
  double y2 = 0;
  const double norm = 1 + k + k * k;
  for (double& sample : samples) {
    const double x = sample;
    sample = (k * k * (x + 2 * x1 + x2) - 2 * (k * k - 1) * y1 - (1 - k + k * k) * y2) / norm;
    x2 = x1;
    x1 = x;
    y2 = y1;
    y1 = sample;
  }
}

}  // namespace

double burst_attack(const NoiseBurst& burst) {
  return (1 - burst.hardness) * 0.01 + 0.001;
}

double burst_cutoff(const NoiseBurst& burst) {
  return (1 - burst.size) * 9500 + 500;
}

modal::ContactForce noise_burst(const NoiseBurst& burst, double sample_rate,
                                core::RandomStream& random) {
  check_part(burst.hardness, "hardness");
  check_part(burst.size, "size");
  if (!(sample_rate > 0 && sample_rate <= 1e8)) {
    throw core::InputError(fmt::format(
        "noise burst: the sample rate must lie between 0 and 100 MHz, not {} Hz", sample_rate));
  }
  const auto attack = std::max(1.0, std::round(burst_attack(burst) * sample_rate));
  const auto length = static_cast<std::size_t>(2 * attack) + 1;
  const double cutoff = burst_cutoff(burst);
  const bool filtered = cutoff < sample_rate / 2;
  // The slowest pole of the low-pass falls as exp(-pi cutoff t).
  const double ringing =
      filtered ? std::ceil(-std::log(filter_tail) * sample_rate / (std::numbers::pi * cutoff)) : 0;

  std::vector<double> force(length + static_cast<std::size_t>(ringing) + 1, 0.0);
  double energy = 0;  // of the envelope under noise of variance 1/3
  for (std::size_t n = 0; n < length; ++n) {
    const double envelope = 1 - std::abs(static_cast<double>(n) - attack) / attack;
    energy += envelope * envelope / 3;
    force[n] = envelope * random.uniform(-1, 1);
  }
  if (filtered) low_pass(force, cutoff, sample_rate);
  // Mean |sum of f dt exp(-i w t)|^2 = dt^2 energy for noise without correlation.
  const double scale = sample_rate / std::sqrt(energy);
  for (double& value : force) value *= scale;
  force.front() = 0;
  force.back() = 0;
  const double duration = static_cast<double>(force.size() - 1) / sample_rate;
  return {duration, std::move(force)};
}

}  // namespace carillon::synth::contact
