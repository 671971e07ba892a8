#pragma once

#include <cmath>
#include <numbers>

#include "core/random.hpp"
#include "eval/damping/damping_data.hpp"

namespace carillon::eval {

/// Damping drawn from d = 5 + 2e-8 omega^2 + N(0, sigma^2) + Exp(mean tau), frequencies even from
/// 300 Hz to 10 kHz; what is not positive is drawn again. `fraction` adds an error in proportion to
/// the law.
struct Draw {
  std::size_t points = 30;
  double sigma = 1;
  double tau = 10;
  double fraction = 0;
};

inline double true_decay_rate(double hertz) {
  return 5 + 2e-8 * std::pow(2 * std::numbers::pi * hertz, 2);
}

inline damping::DampingData drawn_features(const Draw& draw, std::uint64_t repetition) {
  core::RandomStream random(7, repetition, "test.features");
  damping::DampingData data;
  while (data.size() < draw.points) {
    const double f = random.uniform(300, 10000);
    const double excess = draw.tau > 0 ? -draw.tau * std::log1p(-random.uniform()) : 0;
    const double law = true_decay_rate(f);
    const double d = law + std::hypot(draw.sigma, draw.fraction * law) * random.normal() + excess;
    if (d <= 0) continue;
    data.eigenvalues.push_back(std::pow(2 * std::numbers::pi * f, 2));
    data.coefficients.push_back(2 * d);
  }
  return data;
}

}  // namespace carillon::eval
