#include "eval/damping/damping_data.hpp"

#include <cmath>

namespace carillon::eval::damping {

DampingData damping_data(std::span<const features::Feature> features) {
  DampingData data;
  bool known = true;
  for (const features::Feature& feature : features) {
    if (feature.reverberant) continue;
    data.eigenvalues.push_back(features::eigenvalue(feature));
    data.coefficients.push_back(2 * feature.decay_rate);
    data.errors.push_back(2 * feature.decay_rate_error);
    known = known && std::isfinite(feature.decay_rate_error);
  }
  if (!known) data.errors.clear();
  return data;
}

}  // namespace carillon::eval::damping
