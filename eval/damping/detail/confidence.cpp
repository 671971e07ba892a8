#include "eval/damping/detail/confidence.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/numbers.hpp"
#include "core/random.hpp"

namespace carillon::eval::damping {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

using core::infinity;

/// How other parameters follow when one is held elsewhere: d others / d held, and the curvature
/// along that way, by the Hessian at the minimum.
struct Valley {
  VectorXd direction;  ///< 1 at the held one
  double slope = 0;
  double curvature = 0;
};

Valley valley_of(const LocalModel& at, const VectorXd& x, const Box& box, Index held) {
  std::vector<Index> free;
  for (Index i = 0; i < x.size(); ++i) {
    if (i != held && x[i] > box.low[i] && x[i] < box.high[i]) free.push_back(i);
  }
  Valley valley{VectorXd::Unit(x.size(), held), at.gradient[held], at.hessian(held, held)};
  if (free.empty()) return valley;
  const MatrixXd block = at.hessian(free, free);
  const VectorXd side = at.hessian(free, std::vector<Index>{held});
  const Eigen::LLT<MatrixXd> factor(block);
  if (factor.info() != Eigen::Success) return valley;
  const VectorXd follow = factor.solve(-side);
  valley.direction(free) = follow;
  valley.curvature += side.dot(follow);
  return valley;
}

/// One end of an interval.
class Side {
 public:
  Side(const Likelihood& likelihood, const LocalModel& at, Index held, double direction,
       double drop)
      : likelihood_(likelihood), at_(at), held_(held), direction_(direction), drop_(drop) {
    near_ = likelihood.best;
  }

  /// Value of the held parameter where the log-likelihood has dropped; its bound where it has not
  /// by then, infinite where it never does.
  double find() {
    const double best = likelihood_.best[held_];
    const double bound = direction_ < 0 ? likelihood_.box.low[held_] : likelihood_.box.high[held_];
    if (best == bound) return bound;
    const double goal = std::sqrt(2 * drop_);
    double inside = 0, inside_root = 0;  // distance, and sqrt(2 drop) there
    double outside = infinity, outside_root = 0;
    double distance = first_distance();
    for (int attempt = 0; attempt < 60; ++attempt) {
      const double limit = std::abs(bound - best);
      const bool last = distance >= limit;
      if (last) distance = limit;
      const double root = root_at(best + direction_ * distance);
      if (std::abs(root - goal) < 1e-3 * goal) return best + direction_ * distance;
      if (root < goal) {
        if (last) return bound;
        inside = distance;
        inside_root = root;
        if (std::isinf(outside)) {
          if (attempt > 25) return direction_ * infinity;
          // The root grows about linearly; where it does not grow, faster and faster.
          distance *= std::clamp(1.05 * goal / std::max(root, 1e-3), 1.2, 5.0);
          continue;
        }
      } else {
        outside = distance;
        outside_root = root;
      }
      // Between the two, straight; kept off the ends so that the bracket always shrinks.
      const double fraction =
          std::isfinite(outside_root) ? (goal - inside_root) / (outside_root - inside_root) : 0.5;
      distance = inside + std::clamp(fraction, 0.05, 0.95) * (outside - inside);
      if (outside - inside < 1e-9 * outside) break;
    }
    return best + direction_ * inside;
  }

 private:
  double first_distance() const {
    const Valley valley = valley_of(at_, likelihood_.best, likelihood_.box, held_);
    const double goal = drop_ / likelihood_.weight;
    const double slope = std::max(0.0, direction_ * valley.slope);
    const double curvature = std::max(valley.curvature, 1e-12 * at_.hessian(held_, held_));
    const double root = std::sqrt(slope * slope + 2 * curvature * goal);
    const double distance = 2 * goal / (slope + root);
    return std::isfinite(distance) && distance > 0 ? distance : 1e-3;
  }

  double root_at(double value) {
    Box box = likelihood_.box;
    box.low[held_] = box.high[held_] = value;
    // From the last minimum, along the valley that leads on.
    VectorXd start = near_;
    const Valley valley =
        valley_of(near_at_.gradient.size() ? near_at_ : at_, near_, likelihood_.box, held_);
    start += (value - near_[held_]) * valley.direction;
    NewtonOptions options;
    options.tolerance = 1e-9;
    BoundedMinimum found = minimise(likelihood_.objective, start, box, options);
    if (!found.converged) {
      VectorXd plain = near_;
      plain[held_] = value;
      const BoundedMinimum again = minimise(likelihood_.objective, plain, box, options);
      if (again.at.gradient.size() && !(again.at.value > found.at.value)) found = again;
    }
    if (!std::isfinite(found.at.value) || found.at.gradient.size() == 0) return infinity;
    const double drop = likelihood_.weight * (found.at.value - at_.value);
    const double root = std::sqrt(2 * std::max(0.0, drop));
    if (root < 2 * std::sqrt(2 * drop_)) {
      near_ = found.x;
      near_at_ = found.at;
    }
    return root;
  }

  const Likelihood& likelihood_;
  const LocalModel& at_;
  Index held_;
  double direction_;
  double drop_;
  VectorXd near_;
  LocalModel near_at_;
};

}  // namespace

core::Range profile_interval(const ScaledLaw& law, const Likelihood& likelihood, std::size_t alpha,
                             double drop) {
  const auto held = static_cast<Index>(alpha);
  const LocalModel at = likelihood.objective(likelihood.best);
  VectorXd x = likelihood.best.head(law.size());
  const auto alpha_at = [&](double value) {
    x[held] = value;
    return law.alphas(x)[alpha];
  };
  // A parameter may run against its alpha.
  const double best = likelihood.best[held];
  const double sign = alpha_at(best + 1) > alpha_at(best) ? 1 : -1;
  const auto end = [&](double direction) {
    const double value = Side(likelihood, at, held, sign * direction, drop).find();
    // A bound other than zero is the search's, not the law's.
    const bool at_bound = value == law.box.low[held] || value == law.box.high[held];
    if (std::isinf(value) || (at_bound && value != 0)) return direction * infinity;
    return alpha_at(value);
  };
  return {end(-1), end(1)};
}

std::vector<core::Range> lower_bound_intervals(const ScaledLaw& law, const VectorXd& target,
                                               const VectorXd& x) {
  constexpr int repetitions = 200;
  const VectorXd curve = law.curve(x).values;
  const double excess = std::max(0.0, (target - curve).mean());
  const std::vector<double> found = law.alphas(x);
  std::vector<std::vector<double>> drawn(found.size());
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    core::RandomStream random(0, static_cast<std::uint64_t>(repetition), "fit.lower_bound");
    VectorXd sample = curve;
    for (double& value : sample) value -= excess * std::log1p(-random.uniform());
    const std::vector<double> alphas = law.alphas(lower_bound(law, sample, &x).x);
    for (std::size_t k = 0; k < alphas.size(); ++k) drawn[k].push_back(alphas[k]);
  }
  std::vector<core::Range> intervals;
  for (std::size_t k = 0; k < found.size(); ++k) {
    std::sort(drawn[k].begin(), drawn[k].end());
    // As far as the drawn ones lie from what they were drawn with, the truth lies the other way.
    const std::size_t cut = repetitions / 40;
    const double above = drawn[k][repetitions - 1 - cut] - found[k];
    const double below = drawn[k][cut] - found[k];
    intervals.push_back({found[k] - above, found[k] - below});
  }
  return intervals;
}

}  // namespace carillon::eval::damping
