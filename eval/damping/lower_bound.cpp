#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/damping/detail/estimators.hpp"
#include "eval/damping/detail/linear_program.hpp"

namespace carillon::eval::damping {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using core::infinity;

/// The step from x, within +-radius in the parameters `which`, that raises the sum of the curve
/// most while the curve's tangent stays below the target.
VectorXd best_step(const ScaledLaw& law, const Curve& curve, const VectorXd& x,
                   const VectorXd& target, const std::vector<Index>& which, double radius) {
  const auto n = static_cast<Index>(which.size());
  // Columns of size one, so that the program's box suits all.
  MatrixXd slopes = curve.slopes(Eigen::all, which);
  const VectorXd sizes = slopes.cwiseAbs().colwise().maxCoeff().cwiseMax(1e-300).transpose();
  slopes *= sizes.cwiseInverse().asDiagonal();
  std::vector<std::pair<VectorXd, double>> bounds;
  for (Index k = 0; k < n; ++k) {
    const Index at = which[std::size_t(k)];
    const double low = std::max(law.box.low[at] - x[at], -radius);
    const double high = std::min(law.box.high[at] - x[at], radius);
    if (std::isfinite(low)) bounds.emplace_back(-VectorXd::Unit(n, k), -low * sizes[k]);
    if (std::isfinite(high)) bounds.emplace_back(VectorXd::Unit(n, k), high * sizes[k]);
  }
  const Index points = target.size();
  const auto more = static_cast<Index>(bounds.size());
  MatrixXd rows(points + more, n);
  VectorXd limits(points + more);
  rows.topRows(points) = slopes;
  limits.head(points) = target - curve.values;
  for (Index k = 0; k < more; ++k) {
    rows.row(points + k) = bounds[std::size_t(k)].first.transpose();
    limits[points + k] = bounds[std::size_t(k)].second;
  }
  const VectorXd objective = slopes.colwise().sum().transpose() / static_cast<double>(points);
  VectorXd step = VectorXd::Zero(x.size());
  step(which) = linear_program(rows, limits, objective).cwiseQuotient(sizes);
  return step;
}

/// Mean excess, and how far the curve is above the lowest point that it should be below.
struct Merit {
  double excess = infinity;
  double above = infinity;
  /// Lifting a whole curve gains as much excess as it is lifted: being above costs more than that.
  double cost() const { return excess + 10 * above; }
};

Merit merit_of(const VectorXd& values, const VectorXd& target) {
  if (!values.allFinite()) return {};
  const VectorXd excess = target - values;
  return {excess.mean(), std::max(0.0, -excess.minCoeff())};
}

/// The program keeps bounds as well as rounding lets it.
VectorXd stepped(const ScaledLaw& law, const VectorXd& x, const VectorXd& step) {
  return (x + step).cwiseMax(law.box.low).cwiseMin(law.box.high);
}

VectorXd without(const VectorXd& candidate, const std::vector<Index>& linear) {
  VectorXd x = candidate;
  for (const Index k : linear) x[k] = 0;
  return x;
}

/// The same curve's shape with its linear parameters found; nothing where no such curve lies below
/// all points, or the shape is not defined.
std::optional<VectorXd> with_linear_part(const ScaledLaw& law, const VectorXd& shape,
                                         const VectorXd& target) {
  const VectorXd x = without(shape, law.linear);
  const Curve curve = law.curve(x);
  if (!curve.values.allFinite() || !curve.slopes.allFinite()) return {};
  if (law.linear.empty()) return x;
  try {
    return stepped(law, x, best_step(law, curve, x, target, law.linear, infinity));
  } catch (const core::SolverError&) {
    return {};
  }
}

/// The best of the candidates, each with its linear parameters found.
VectorXd best_candidate(const ScaledLaw& law, const VectorXd& target) {
  VectorXd best = law.candidates.front();
  double minimum = infinity;
  for (const VectorXd& candidate : law.candidates) {
    const auto x = with_linear_part(law, candidate, target);
    if (!x) continue;
    const double cost = merit_of(law.curve(*x).values, target).cost();
    if (cost < minimum) {
      minimum = cost;
      best = *x;
    }
  }
  return best;
}

}  // namespace

Estimate lower_bound(const ScaledLaw& law, const VectorXd& target, const VectorXd* start,
                     const Watch& watch) {
  Estimate found;
  found.x = start != nullptr && !law.is_linear() ? *start : best_candidate(law, target);
  found.iterations = 1;
  Curve curve = law.curve(found.x);
  double cost = merit_of(curve.values, target).cost();
  if (watch) watch(found.x, merit_of(curve.values, target).excess, 0);
  if (law.is_linear()) {
    found.converged = std::isfinite(cost);
    return found;
  }
  // Linear programs of tangents, within a radius that the tangents hold for.
  std::vector<Index> all;
  for (Index k = 0; k < law.size(); ++k) all.push_back(k);
  found.converged = false;
  double radius = 0.1;
  while (found.iterations < 200 && std::isfinite(cost)) {
    VectorXd step;
    try {
      step = best_step(law, curve, found.x, target, all, radius);
    } catch (const core::SolverError&) {
      radius *= 4;  // where the curve is above points, no short step leads below them
      if (radius > 1e6) break;
      continue;
    }
    ++found.iterations;
    VectorXd to = stepped(law, found.x, step);
    // Where the curve bends away from its tangent the linear parameters bring it back.
    if (const auto x = with_linear_part(law, to, target)) to = *x;
    const Curve next = law.curve(to);
    const Merit merit = merit_of(next.values, target);
    const bool good = next.slopes.allFinite() && merit.cost() < cost;
    const double gain = cost - merit.cost();
    const double length = step.cwiseAbs().maxCoeff();
    if (good) {
      found.x = to;
      curve = next;
      cost = merit.cost();
      if (watch) watch(found.x, merit.excess, length);
      radius *= 2;
    } else {
      radius = length / 4;
    }
    if (length < 1e-10 || radius < 1e-12 || (good && gain < 1e-13 * (1 + std::abs(cost)))) {
      found.converged = true;
      break;
    }
  }
  return found;
}

}  // namespace carillon::eval::damping
