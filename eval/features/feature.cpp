#include "eval/features/feature.hpp"

#include <numbers>

namespace carillon::eval::features {

double eigenvalue(const Feature& feature) {
  const double omega = 2 * std::numbers::pi * feature.frequency;
  return omega * omega + feature.decay_rate * feature.decay_rate;
}

}  // namespace carillon::eval::features
