#include "eval/damping/information.hpp"

#include <cmath>

namespace carillon::eval {

std::size_t fitted_numbers(const DampingFit& fit) {
  return fit.model.parameters.size() + (fit.estimator == Estimator::emg ? 2 : 1);
}

double akaike(const DampingFit& fit) {
  return 2 * static_cast<double>(fitted_numbers(fit)) - 2 * fit.log_likelihood;
}

double bayesian(const DampingFit& fit) {
  return static_cast<double>(fitted_numbers(fit)) * std::log(static_cast<double>(fit.points)) -
         2 * fit.log_likelihood;
}

}  // namespace carillon::eval
