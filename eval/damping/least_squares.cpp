#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/damping/detail/estimators.hpp"

namespace carillon::eval::damping {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Least squares of columns, some of whose factors must not be negative: of all choices of factors
/// held at zero the best (laws have two such factors at most).
VectorXd bounded_fit(const MatrixXd& columns, const VectorXd& target,
                     const std::vector<bool>& bounded) {
  const Index n = columns.cols();
  const VectorXd norms =
      columns.colwise().norm().cwiseMax(std::numeric_limits<double>::min()).transpose();
  std::vector<Index> bounds;
  for (Index k = 0; k < n; ++k) {
    if (bounded[std::size_t(k)]) bounds.push_back(k);
  }
  VectorXd best = VectorXd::Zero(n);
  double minimum = std::numeric_limits<double>::infinity();
  for (unsigned held = 0; held < (1U << bounds.size()); ++held) {
    std::vector<Index> free;
    for (Index k = 0; k < n; ++k) {
      const auto at = std::find(bounds.begin(), bounds.end(), k) - bounds.begin();
      if (at == Index(bounds.size()) || ((held >> at) & 1U) == 0) free.push_back(k);
    }
    VectorXd x = VectorXd::Zero(n);
    if (!free.empty()) {
      const MatrixXd scaled = columns(Eigen::all, free) * norms(free).cwiseInverse().asDiagonal();
      x(free) = scaled.colPivHouseholderQr().solve(target).cwiseQuotient(norms(free));
    }
    const auto negative = [&](Index k) { return x[k] < 0; };
    if (std::any_of(bounds.begin(), bounds.end(), negative)) continue;
    const double rest = (columns * x - target).squaredNorm();
    if (rest < minimum) {
      minimum = rest;
      best = x;
    }
  }
  return best;
}

/// The candidate with those parameters found that c is linear in.
VectorXd with_linear_part(const ScaledLaw& law, const VectorXd& candidate, const VectorXd& target,
                          double& rest) {
  rest = std::numeric_limits<double>::infinity();
  VectorXd x = candidate;
  for (const Index k : law.linear) x[k] = 0;
  Curve curve = law.curve(x);
  if (!curve.values.allFinite() || !curve.slopes.allFinite()) return x;
  if (!law.linear.empty()) {
    std::vector<bool> bounded;
    for (const Index k : law.linear) bounded.push_back(law.box.low[k] == 0);
    const MatrixXd columns = curve.slopes(Eigen::all, law.linear);
    const VectorXd factors = bounded_fit(columns, target - curve.values, bounded);
    x(law.linear) = factors;
    curve.values += columns * factors;
  }
  const double sum = (curve.values - target).squaredNorm();
  if (std::isfinite(sum)) rest = sum;
  return x;
}

/// The best of the candidates with their sums of squares, best first.
std::vector<std::pair<VectorXd, double>> best_candidates(const ScaledLaw& law,
                                                         const VectorXd& target,
                                                         std::size_t maximum) {
  std::vector<std::pair<VectorXd, double>> all;
  for (const VectorXd& candidate : law.candidates) {
    double rest = 0;
    const VectorXd x = with_linear_part(law, candidate, target, rest);
    all.emplace_back(x, rest);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.second < b.second; });
  all.resize(std::min(all.size(), maximum));
  return all;
}

}  // namespace

Objective misfit_objective(const ScaledLaw& law, const VectorXd& target, double unit) {
  return [&law, target, unit](const VectorXd& x) {
    const Curve curve = law.curve(x);
    const VectorXd rest = curve.values - target;
    LocalModel model{rest.squaredNorm() / (2 * unit), curve.slopes.transpose() * rest / unit,
                     curve.slopes.transpose() * curve.slopes / unit};
    if (law.bend) model.hessian += law.bend(x, rest) / unit;
    return model;
  };
}

Estimate least_squares(const ScaledLaw& law, const VectorXd& target, const Watch& watch) {
  const auto [best, minimum] = best_candidates(law, target, 1).front();
  const double points = static_cast<double>(target.size());
  if (law.is_linear()) {
    if (watch) watch(best, minimum / points, 0);
    return {best, std::isfinite(minimum), 1};
  }
  // In units of the best candidate's misfit, but not of rounding's where the data are perfect.
  const double unit = points * std::max(minimum / points, 1e-7);
  NewtonOptions options;
  options.watch = [&](const VectorXd& x, double value, double gradient) {
    if (watch) watch(x, 2 * unit * value / points, gradient);
  };
  const BoundedMinimum found =
      minimise(misfit_objective(law, target, unit), best, law.box, options);
  return {found.x, found.converged, found.iterations};
}

ScaledLaw settled_law(const ScaledLaw& law, const VectorXd& target,
                      const std::function<ScaledLaw(const std::vector<double>&)>& near) {
  constexpr std::size_t tries = 5;
  ScaledLaw best;
  double minimum = std::numeric_limits<double>::infinity();
  for (const auto& [x, rest] : best_candidates(law, target, tries)) {
    const ScaledLaw first = near(law.alphas(x));
    const Estimate found = least_squares(first, target);
    const double sum = (first.curve(found.x).values - target).squaredNorm();
    if (best.curve && !(sum < minimum)) continue;
    minimum = sum;
    best = near(first.alphas(found.x));
  }
  return best;
}

}  // namespace carillon::eval::damping
