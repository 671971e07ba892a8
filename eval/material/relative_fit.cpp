#include "eval/material/relative_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/material/detail/minimise.hpp"

namespace carillon::eval::material {

namespace {

using synth::damping::DampingKind;

constexpr double worst = 1e6;    // of the sum, where a law is not positive
constexpr double farthest = 14;  // in logarithms or sizes: beyond, nothing bounds a parameter
constexpr double tolerance = 1e-9;
constexpr int max_evaluations = 2000;
/// Points beside a law's parameters from which excess can be told from error.
constexpr std::size_t points_for_excess = 10;
/// Part of what a term usually is that counts as nothing.
constexpr double nothing = 1e-5;

/// A law's parameters as they are searched: logarithms of those that are positive, others in sizes.
struct Search {
  const damping::DampingData& data;
  damping::DampingLaw law;
  std::vector<bool> logarithmic;
  std::vector<double> sizes;

  std::vector<double> parameters(std::span<const double> y) const {
    std::vector<double> alphas;
    for (std::size_t k = 0; k < y.size(); ++k) {
      alphas.push_back(sizes[k] * (logarithmic[k] ? std::exp(y[k]) : y[k]));
    }
    return alphas;
  }

  /// Sum of squared logarithms of c over the law's.
  double operator()(std::span<const double> y) const {
    const synth::damping::DampingModel model{law.kind, parameters(y), law.expression};
    if (synth::damping::damping_fault(model)) return worst;
    const std::vector<double> values =
        synth::damping::damping_coefficients(model, data.eigenvalues);
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!(values[i] > 0)) return worst;
      const double residual = std::log(data.coefficients[i] / values[i]);
      sum += residual * residual;
    }
    return std::isfinite(sum) ? std::min(sum, worst) : worst;
  }
};

bool is_positive(DampingKind kind, std::size_t k) {
  return kind == DampingKind::rayleigh || (kind == DampingKind::power && k == 0) ||
         (kind == DampingKind::hybrid && k < 2);
}

/// Of a law like the start, in units of its parameters or of what would be usual for them.
Search search_of(const damping::DampingData& data, const damping::DampingLaw& law,
                 const std::vector<double>& start) {
  Search search{data, law, {}, {}};
  const double usual = core::median(data.coefficients);
  const double eigenvalue = core::median(data.eigenvalues);
  for (std::size_t k = 0; k < start.size(); ++k) {
    const bool series = law.kind == DampingKind::rayleigh || law.kind == DampingKind::caughey;
    const double term = usual * std::pow(eigenvalue, series ? -static_cast<double>(k) : 0.0);
    search.logarithmic.push_back(is_positive(law.kind, k));
    const double size = series ? std::max(std::abs(start[k]), nothing * term) : std::abs(start[k]);
    search.sizes.push_back(size > 0 ? size : 1);
  }
  return search;
}

/// The sum's minimum with one parameter held.
Minimum minimum_along(const Search& search, const std::vector<double>& from, std::size_t k,
                      double value) {
  std::vector<double> rest = from;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
  const auto with = [&](std::span<const double> others) {
    std::vector<double> y(others.begin(), others.end());
    y.insert(y.begin() + static_cast<std::ptrdiff_t>(k), value);
    return y;
  };
  Minimum found;
  if (rest.empty()) return {{value}, search(with({})), 1, true};
  found = minimise([&](std::span<const double> others) { return search(with(others)); }, rest,
                   std::vector<double>(rest.size(), 0.1), tolerance, max_evaluations);
  found.x = with(found.x);
  return found;
}

/// Where a profile passes a limit; infinite where it never does.
double end_of(const Search& search, const std::vector<double>& best, std::size_t k, double side,
              double limit) {
  double inside = 0;
  double outside = 1e-4;
  std::vector<double> from = best;
  for (;; outside *= 2) {
    if (outside > farthest) return side * core::infinity;
    const Minimum found = minimum_along(search, from, k, best[k] + side * outside);
    if (found.value > limit) break;
    from = found.x;
    inside = outside;
  }
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (inside + outside);
    const Minimum found = minimum_along(search, from, k, best[k] + side * middle);
    (found.value > limit ? outside : inside) = middle;
  }
  return best[k] + side * outside;
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
  const Search search = search_of(data, law, fit.model.parameters);
  std::vector<double> start;
  for (std::size_t k = 0; k < count; ++k) {
    const double in_sizes = fit.model.parameters[k] / search.sizes[k];
    start.push_back(search.logarithmic[k] ? std::log(std::max(in_sizes, nothing)) : in_sizes);
  }
  const std::vector<double> steps(count, 0.2);
  const auto objective = [&](std::span<const double> y) { return search(y); };
  // A second search begins with large steps where the first ended with small ones.
  Minimum best = minimise(objective, start, steps, tolerance, max_evaluations);
  best = minimise(objective, best.x, steps, tolerance, max_evaluations);
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
    const auto parameter = [&](double end) {
      if (search.logarithmic[k]) return search.sizes[k] * std::exp(end);
      return search.sizes[k] * end;
    };
    fit.confidence95.push_back({parameter(end_of(search, best.x, k, -1, limit)),
                                parameter(end_of(search, best.x, k, 1, limit))});
  }
  return fit;
}

damping::DampingFit fit_matched(const damping::DampingData& data, const damping::DampingLaw& law) {
  if (data.size() < law.parameters + points_for_excess) return fit_relative(data, law);
  return damping::fit_damping(data, law, {.estimator = damping::Estimator::emg_relative});
}

}  // namespace carillon::eval::material
