#include "eval/damping/damping_data.hpp"

#include <cmath>

namespace carillon::eval {

DampingData damping_data(std::span<const Feature> features) {
  DampingData data;
  bool known = true;
  for (const Feature& feature : features) {
    if (feature.reverberant) continue;
    data.eigenvalues.push_back(eigenvalue(feature));
    data.coefficients.push_back(2 * feature.decay_rate);
    data.errors.push_back(2 * feature.decay_rate_error);
    known = known && std::isfinite(feature.decay_rate_error);
  }
  if (!known) data.errors.clear();
  return data;
}

}  // namespace carillon::eval
