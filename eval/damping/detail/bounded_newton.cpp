#include "eval/damping/detail/bounded_newton.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace carillon::eval::damping {

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

/// A damped Newton step.
struct Step {
  VectorXd to;
  double foretold = 0;  ///< gain of the step if no bound cut it short
};

/// @return nothing where the damped Hessian is not positive definite
std::optional<Step> newton_step(const VectorXd& x, const LocalModel& at, const Indices& free,
                                double damping, const Box& box) {
  MatrixXd hessian = at.hessian(free, free);
  const double minimum = 1e-12 * std::max(hessian.diagonal().cwiseAbs().maxCoeff(),
                                          std::numeric_limits<double>::min());
  hessian.diagonal() += damping * hessian.diagonal().cwiseAbs().cwiseMax(minimum);
  const Eigen::LLT<MatrixXd> factor(hessian);
  if (factor.info() != Eigen::Success) return {};
  const VectorXd step = factor.solve(-at.gradient(free));
  if (!step.allFinite()) return {};
  VectorXd to = x;
  to(free) += step;
  return Step{into_box(to, box), -0.5 * at.gradient(free).dot(step)};
}

}  // namespace

BoundedMinimum minimise(const Objective& objective, const VectorXd& start, const Box& box,
                        const NewtonOptions& options) {
  constexpr double max_damping = 1e16;
  BoundedMinimum found;
  found.x = into_box(start, box);
  found.at = objective(found.x);
  if (!is_finite(found.at)) return found;
  const auto tell = [&] {
    if (options.watch) options.watch(found.x, found.at.value, found.gradient);
  };
  double damping = 0;
  Indices free = free_ones(found.x, found.at.gradient, box);
  found.gradient = largest(found.at.gradient, free);
  tell();
  found.converged = found.gradient == 0;
  while (!found.converged && found.iterations < options.max_iterations) {
    const auto step = newton_step(found.x, found.at, free, damping, box);
    const VectorXd to = step ? step->to : found.x;
    const VectorXd by = to - found.x;
    const double expected = -found.at.gradient.dot(by) - 0.5 * by.dot(found.at.hessian * by);
    const double size = 1 + std::abs(found.at.value);
    // What a Newton step would gain does not depend on the parameters' units.
    const bool last = step && damping <= 1 && step->foretold <= options.tolerance * size;
    bool good = false;
    if (expected > 0) {
      LocalModel next = objective(to);
      const double gain = found.at.value - next.value;
      // The last step is one more than needed, and its gain may drown in rounding.
      good = is_finite(next) && (gain >= 0.01 * expected || (last && gain > -1e-14 * size));
      if (good) {
        if (gain > 0.75 * expected) damping = damping < 1e-6 ? 0 : damping / 10;
        found.x = to;
        found.at = std::move(next);
        free = free_ones(found.x, found.at.gradient, box);
        found.gradient = largest(found.at.gradient, free);
        ++found.iterations;
        tell();
      }
    }
    found.converged = last || found.gradient == 0;
    if (!good) {
      damping = std::max(1e-4, 10 * damping);
      if (damping > max_damping) break;
    }
  }
  return found;
}

}  // namespace carillon::eval::damping
