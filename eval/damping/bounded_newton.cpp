#include "eval/damping/bounded_newton.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace carillon::eval {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Indices = Eigen::VectorX<Index>;

VectorXd into_box(const VectorXd& x, const Box& box) {
  return x.cwiseMax(box.low).cwiseMin(box.high);
}

/// Parameters that no bound holds against the gradient.
Indices free_ones(const VectorXd& x, const VectorXd& gradient, const Box& box) {
  Indices free(x.size());
  Index count = 0;
  for (Index i = 0; i < x.size(); ++i) {
    if (box.low[i] == box.high[i]) continue;
    if (x[i] <= box.low[i] && gradient[i] >= 0) continue;
    if (x[i] >= box.high[i] && gradient[i] <= 0) continue;
    free[count++] = i;
  }
  return free.head(count);
}

double largest(const VectorXd& gradient, const Indices& free) {
  return free.size() == 0 ? 0 : gradient(free).cwiseAbs().maxCoeff();
}

bool is_finite(const LocalModel& model) {
  return std::isfinite(model.value) && model.gradient.allFinite() && model.hessian.allFinite();
}

/// Where the damped Newton step leads; the place itself where the damped Hessian is not positive
/// definite.
VectorXd stepped(const VectorXd& x, const LocalModel& at, const Indices& free, double damping,
                 const Box& box) {
  MatrixXd hessian = at.hessian(free, free);
  const double least = 1e-12 * std::max(hessian.diagonal().cwiseAbs().maxCoeff(),
                                        std::numeric_limits<double>::min());
  hessian.diagonal() += damping * hessian.diagonal().cwiseAbs().cwiseMax(least);
  const Eigen::LLT<MatrixXd> factor(hessian);
  if (factor.info() != Eigen::Success) return x;
  const VectorXd step = factor.solve(-at.gradient(free));
  if (!step.allFinite()) return x;
  VectorXd to = x;
  to(free) += step;
  return into_box(to, box);
}

}  // namespace

Minimum minimise(const Objective& objective, const VectorXd& start, const Box& box,
                 const NewtonOptions& options) {
  constexpr double rounding = 4 * std::numeric_limits<double>::epsilon();
  constexpr double most_damping = 1e16;
  Minimum found;
  found.x = into_box(start, box);
  found.at = objective(found.x);
  if (!is_finite(found.at)) return found;
  double damping = 0;
  Indices free = free_ones(found.x, found.at.gradient, box);
  found.gradient = largest(found.at.gradient, free);
  if (options.watch) options.watch(found.x, found.at.value, found.gradient);
  while (found.gradient > options.tolerance && found.iterations < options.max_iterations) {
    const VectorXd to = stepped(found.x, found.at, free, damping, box);
    const VectorXd step = to - found.x;
    const double expected = -found.at.gradient.dot(step) - 0.5 * step.dot(found.at.hessian * step);
    bool good = false;
    if (expected > 0) {
      LocalModel next = objective(to);
      if (is_finite(next)) {
        const double gain = found.at.value - next.value;
        const Indices next_free = free_ones(to, next.gradient, box);
        const double next_gradient = largest(next.gradient, next_free);
        // Where gains drown in rounding, the gradient still tells which way is down.
        const bool drowned = expected < rounding * (1 + std::abs(found.at.value));
        good = gain >= 0.01 * expected || (drowned && next_gradient < found.gradient &&
                                           gain > -rounding * (1 + std::abs(found.at.value)));
        if (good) {
          if (gain > 0.75 * expected) damping = damping < 1e-6 ? 0 : damping / 10;
          found.x = to;
          found.at = std::move(next);
          found.gradient = next_gradient;
          free = next_free;
          ++found.iterations;
          if (options.watch) options.watch(found.x, found.at.value, found.gradient);
        }
      }
    }
    if (!good) {
      damping = std::max(1e-4, 10 * damping);
      if (damping > most_damping) break;
    }
  }
  // A hundred times the tolerance is where rounding in the sum over the data may stop it.
  found.converged = found.gradient <= 100 * options.tolerance;
  return found;
}

}  // namespace carillon::eval
