#include "eval/material/detail/law_search.hpp"

#include <algorithm>
#include <cmath>

#include "eval/material/detail/minimise.hpp"

namespace carillon::eval::material {

namespace {

using synth::damping::DampingKind;

constexpr double farthest = 14;  // in logarithms or sizes: beyond, nothing bounds a parameter
constexpr double profile_tolerance = 1e-9;
constexpr int max_profile_evaluations = 2000;
/// Part of what a term usually is that counts as nothing.
constexpr double negligible_part = 1e-5;

bool is_positive(DampingKind kind, std::size_t k) {
  return kind == DampingKind::rayleigh || (kind == DampingKind::power && k == 0) ||
         (kind == DampingKind::hybrid && k < 2);
}

/// The minimum with one coordinate held.
Minimum minimum_along(const LawObjective& objective, const std::vector<double>& from, std::size_t k,
                      double value) {
  std::vector<double> rest = from;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
  const auto with = [&](std::span<const double> others) {
    std::vector<double> y(others.begin(), others.end());
    y.insert(y.begin() + static_cast<std::ptrdiff_t>(k), value);
    return y;
  };
  if (rest.empty()) return {{value}, objective(with({})), 1, true};
  Minimum found =
      minimise([&](std::span<const double> others) { return objective(with(others)); }, rest,
               std::vector<double>(rest.size(), 0.1), profile_tolerance, max_profile_evaluations);
  found.x = with(found.x);
  return found;
}

double end_of(const LawObjective& objective, const std::vector<double>& best, std::size_t k,
              double side, double limit) {
  double inside = 0;
  double outside = 1e-4;
  std::vector<double> from = best;
  for (;; outside *= 2) {
    if (outside > farthest) return side * core::infinity;
    const Minimum found = minimum_along(objective, from, k, best[k] + side * outside);
    if (found.value > limit) break;
    from = found.x;
    inside = outside;
  }
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (inside + outside);
    const Minimum found = minimum_along(objective, from, k, best[k] + side * middle);
    (found.value > limit ? outside : inside) = middle;
  }
  return best[k] + side * outside;
}

}  // namespace

std::vector<double> LawSearch::coordinates(std::span<const double> parameters) const {
  std::vector<double> y;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const double in_sizes = parameters[k] / sizes[k];
    y.push_back(logarithmic[k] ? std::log(std::max(in_sizes, negligible_part)) : in_sizes);
  }
  return y;
}

double LawSearch::parameter(std::size_t k, double coordinate) const {
  return sizes[k] * (logarithmic[k] ? std::exp(coordinate) : coordinate);
}

std::vector<double> LawSearch::parameters(std::span<const double> y) const {
  std::vector<double> alphas;
  for (std::size_t k = 0; k < sizes.size(); ++k) alphas.push_back(parameter(k, y[k]));
  return alphas;
}

std::vector<double> LawSearch::coefficients(std::span<const double> y,
                                            std::span<const double> eigenvalues) const {
  const synth::damping::DampingModel model{law.kind, parameters(y), law.expression};
  if (synth::damping::damping_fault(model)) return {};
  std::vector<double> values = synth::damping::damping_coefficients(model, eigenvalues);
  const bool usable = std::all_of(values.begin(), values.end(),
                                  [](double value) { return value > 0 && std::isfinite(value); });
  if (!usable) values.clear();
  return values;
}

LawSearch law_search(const damping::DampingData& data, const damping::DampingLaw& law,
                     std::span<const double> start) {
  LawSearch search{law, {}, {}};
  const double usual = core::median(data.coefficients);
  const double eigenvalue = core::median(data.eigenvalues);
  for (std::size_t k = 0; k < start.size(); ++k) {
    const bool series = law.kind == DampingKind::rayleigh || law.kind == DampingKind::caughey;
    const double term = usual * std::pow(eigenvalue, series ? -static_cast<double>(k) : 0.0);
    search.logarithmic.push_back(is_positive(law.kind, k));
    const double size =
        series ? std::max(std::abs(start[k]), negligible_part * term) : std::abs(start[k]);
    search.sizes.push_back(size > 0 ? size : 1);
  }
  return search;
}

core::Range profile_range(const LawObjective& objective, const std::vector<double>& best,
                          std::size_t k, double limit) {
  return {end_of(objective, best, k, -1, limit), end_of(objective, best, k, 1, limit)};
}

}  // namespace carillon::eval::material
