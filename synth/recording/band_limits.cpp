#include "synth/recording/band_limits.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace carillon::synth::recording {

namespace {

/// Two poles of quality `q` at an edge.
struct Section {
  double b0, b1, b2, a1, a2;

  void filter(std::span<float> clip) const {
    double s1 = 0, s2 = 0;  // transposed direct form II
    for (float& sample : clip) {
      const double x = sample;
      const double y = b0 * x + s1;
      s1 = b1 * x - a1 * y + s2;
      s2 = b2 * x - a2 * y;
      sample = static_cast<float>(y);
    }
  }
};

/// tan(pi f / rate): the analogue frequency that the bilinear transform takes to the edge.
double warped(double edge, double sample_rate) {
  if (!(edge > 0 && edge < sample_rate / 2)) {
    throw core::InputError(fmt::format("a band limit at {} Hz", edge),
                           fmt::format("above 0 and below half the rate, {} Hz", sample_rate / 2));
  }
  return std::tan(std::numbers::pi * edge / sample_rate);
}

Section low_pass(double k, double q) {
  const double norm = 1 / (1 + k / q + k * k);
  return {k * k * norm, 2 * k * k * norm, k * k * norm, 2 * (k * k - 1) * norm,
          (1 - k / q + k * k) * norm};
}

Section high_pass(double k, double q) {
  const double norm = 1 / (1 + k / q + k * k);
  return {norm, -2 * norm, norm, 2 * (k * k - 1) * norm, (1 - k / q + k * k) * norm};
}

}  // namespace

void cut_above(std::span<float> clip, double edge, double sample_rate) {
  const double k = warped(edge, sample_rate);
  // Pole angles of order 4.
  for (const double angle : {std::numbers::pi / 8, 3 * std::numbers::pi / 8}) {
    low_pass(k, 1 / (2 * std::cos(angle))).filter(clip);
  }
}

void cut_below(std::span<float> clip, double edge, double sample_rate) {
  high_pass(warped(edge, sample_rate), std::numbers::sqrt2 / 2).filter(clip);
}

}  // namespace carillon::synth::recording
