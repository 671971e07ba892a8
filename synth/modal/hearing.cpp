#include "synth/modal/hearing.hpp"

#include <cmath>
#include <limits>

namespace carillon::synth::modal {

double bark(double frequency) {
  const double ratio = frequency / 7500;
  return 13 * std::atan(0.00076 * frequency) + 3.5 * std::atan(ratio * ratio);
}

double hearing_threshold(double frequency) {
  const double f = frequency / 1000;
  if (!(f > 0)) return std::numeric_limits<double>::infinity();
  return 3.64 * std::pow(f, -0.8) - 6.5 * std::exp(-0.6 * (f - 3.3) * (f - 3.3)) +
         1e-3 * f * f * f * f;
}

}  // namespace carillon::synth::modal
