#include "eval/damping/detail/information.hpp"

#include <cmath>
#include <limits>

namespace carillon::eval::damping {

std::size_t fitted_numbers(const DampingFit& fit) {
  const std::size_t others = fit.estimator == Estimator::mixture ? 4
                             : has_excess(fit.estimator)         ? 2
                                                                 : 1;
  return fit.model.parameters.size() + others;
}

double akaike(const DampingFit& fit) {
  const auto k = static_cast<double>(fitted_numbers(fit));
  const double spare = static_cast<double>(fit.points) - k - 1;
  if (!(spare > 0)) return std::numeric_limits<double>::infinity();
  return 2 * k + 2 * k * (k + 1) / spare - 2 * fit.log_likelihood;
}

double bayesian(const DampingFit& fit) {
  return static_cast<double>(fitted_numbers(fit)) * std::log(static_cast<double>(fit.points)) -
         2 * fit.log_likelihood;
}

}  // namespace carillon::eval::damping
