#include "eval/statistics/variance.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

namespace carillon::eval::statistics {

double students_t(double probability, double freedom) {
  return boost::math::quantile(boost::math::students_t(freedom), 0.5 + 0.5 * probability);
}

Variance variance_of_sum(std::span<const double> influences) {
  const auto groups = static_cast<double>(influences.size());
  if (groups < 2) return {std::numeric_limits<double>::quiet_NaN(), 0};
  double squares = 0;
  for (const double one : influences) squares += one * one;
  return {squares * groups / (groups - 1), groups - 1};
}

core::Range around(double estimate, std::initializer_list<Variance> parts, double probability) {
  double sum = 0, squares = 0;
  for (const Variance& part : parts) {
    sum += part.value;
    squares += part.value * part.value / part.freedom;
  }
  if (!(sum > 0)) return {estimate, estimate};
  const double half = students_t(probability, sum * sum / squares) * std::sqrt(sum);
  return {estimate - half, estimate + half};
}

}  // namespace carillon::eval::statistics
