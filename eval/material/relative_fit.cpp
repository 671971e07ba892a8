#include "eval/material/relative_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "core/error.hpp"
#include "eval/material/detail/law_search.hpp"
#include "eval/material/detail/minimise.hpp"

namespace carillon::eval::material {

namespace {

constexpr double worst_squares = 1e6;  // of the sum, where a law is not positive
constexpr double relative_tolerance = 1e-9;
constexpr int max_relative_evaluations = 2000;
/// Points beside a law's parameters from which excess can be told from error.
constexpr std::size_t points_for_excess = 10;

/// Sum of squared logarithms of c over the law's.
double squares(const LawSearch& search, const damping::DampingData& data,
               std::span<const double> y) {
  const std::vector<double> values = search.coefficients(y, data.eigenvalues);
  if (values.empty()) return worst_squares;
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double residual = std::log(data.coefficients[i] / values[i]);
    sum += residual * residual;
  }
  return std::isfinite(sum) ? std::min(sum, worst_squares) : worst_squares;
}

}  // namespace

damping::DampingFit fit_relative(const damping::DampingData& data, const damping::DampingLaw& law) {
  damping::DampingFit fit = damping::fit_damping(
      data, law, {.estimator = damping::Estimator::least_squares, .confidence = false});
  const std::size_t count = fit.model.parameters.size();
  if (data.size() <= count) {
    throw core::InputError(
        fmt::format("{} points tell nothing of the errors of {} parameters", data.size(), count));
  }
  const LawSearch search = law_search(data, law, fit.model.parameters);
  const std::vector<double> start = search.coordinates(fit.model.parameters);
  const std::vector<double> steps(count, 0.2);
  const auto objective = [&](std::span<const double> y) { return squares(search, data, y); };
  // A second search begins with large steps where the first ended with small ones.
  Minimum best = minimise(objective, start, steps, relative_tolerance, max_relative_evaluations);
  best = minimise(objective, best.x, steps, relative_tolerance, max_relative_evaluations);
  fit.model.parameters = search.parameters(best.x);
  const double freedom = static_cast<double>(data.size() - count);
  double known = 0;  // by the features' own errors
  for (std::size_t i = 0; i < data.errors.size(); ++i) {
    const double error = data.errors[i] / data.coefficients[i];
    if (std::isfinite(error)) known += error * error / static_cast<double>(data.size());
  }
  const double variance = std::max(best.value / freedom, known);
  fit.sigma = std::sqrt(variance);
  const double t = boost::math::quantile(boost::math::students_t(freedom), 0.975);
  const double limit = best.value + t * t * variance;
  for (std::size_t k = 0; k < count; ++k) {
    const core::Range range = profile_range(objective, best.x, k, limit);
    fit.confidence95.push_back({search.parameter(k, range.low), search.parameter(k, range.high)});
  }
  return fit;
}

damping::DampingFit fit_matched(const damping::DampingData& data, const damping::DampingLaw& law) {
  if (data.size() < law.parameters + points_for_excess) return fit_relative(data, law);
  return damping::fit_damping(data, law, {.estimator = damping::Estimator::emg_relative});
}

}  // namespace carillon::eval::material
