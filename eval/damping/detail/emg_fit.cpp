#include "eval/damping/detail/emg_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "eval/damping/detail/emg.hpp"

namespace carillon::eval::damping {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd joined(const VectorXd& x, double sigma, double kappa) {
  VectorXd all(x.size() + 2);
  all << x, std::log(sigma), std::log(kappa);
  return all;
}

/// What errors in proportion are in proportion to at least, in units of the law's scale.
constexpr double min_size = 1e-4;

/// By mu again where sigma and kappa are in proportion to it.
EmgDensity following(const EmgDensity& f, double mu) {
  EmgDensity all = f;
  const double widths = f.sigma + f.kappa;
  all.mu += widths / mu;
  all.mu_mu += 2 * (f.mu_sigma + f.mu_kappa) / mu +
               (f.sigma_sigma + 2 * f.sigma_kappa + f.kappa_kappa - widths) / (mu * mu);
  all.mu_sigma += (f.sigma_sigma + f.sigma_kappa) / mu;
  all.mu_kappa += (f.sigma_kappa + f.kappa_kappa) / mu;
  return all;
}

/// Widths of the exponential and the Gaussian with the second and third moment of what is left of
/// the points, as far as such moments can be an EMG's.
struct Widths {
  double exponential = 0;
  double gaussian = 0;
};
Widths widths_of(const VectorXd& rest) {
  const VectorXd central = rest.array() - rest.mean();
  const double deviation = std::sqrt(central.squaredNorm() / static_cast<double>(rest.size()));
  if (deviation == 0) return {};
  const double skewness = (central / deviation).array().cube().mean();
  const double fraction = std::cbrt(std::clamp(skewness / 2, 1e-3, 0.9));
  return {deviation * fraction, deviation * std::sqrt(1 - fraction * fraction)};
}

}  // namespace

Objective emg_objective(const ScaledLaw& law, const VectorXd& target, bool relative) {
  return [&law, target, relative](const VectorXd& all) {
    const Index n = law.size();
    const Index points = target.size();
    const double sigma = std::exp(all[n]);
    const double kappa = std::exp(all[n + 1]);
    const Curve curve = law.curve(all.head(n));
    VectorXd mu(points), mu_mu(points), mu_sigma(points), mu_kappa(points);
    EmgDensity sum;
    for (Index i = 0; i < points; ++i) {
      // A law that is nearly zero or negative somewhere has errors there all the same.
      const double m = curve.values[i];
      const double size = relative ? std::max(m, min_size) : 1;
      EmgDensity density = emg_log_density(target[i], m, size * sigma, size * kappa);
      if (relative && m > min_size) density = following(density, m);
      sum.value += density.value;
      sum.sigma += density.sigma;
      sum.kappa += density.kappa;
      sum.sigma_sigma += density.sigma_sigma;
      sum.sigma_kappa += density.sigma_kappa;
      sum.kappa_kappa += density.kappa_kappa;
      mu[i] = density.mu;
      mu_mu[i] = density.mu_mu;
      mu_sigma[i] = density.mu_sigma;
      mu_kappa[i] = density.mu_kappa;
    }
    const double fraction = -1 / static_cast<double>(points);
    LocalModel model{fraction * sum.value, VectorXd(n + 2), MatrixXd(n + 2, n + 2)};
    model.gradient << curve.slopes.transpose() * mu, sum.sigma, sum.kappa;
    MatrixXd& hessian = model.hessian;
    hessian.topLeftCorner(n, n) = curve.slopes.transpose() * mu_mu.asDiagonal() * curve.slopes;
    if (law.bend) hessian.topLeftCorner(n, n) += law.bend(all.head(n), mu);
    hessian.col(n).head(n) = curve.slopes.transpose() * mu_sigma;
    hessian.col(n + 1).head(n) = curve.slopes.transpose() * mu_kappa;
    hessian.bottomLeftCorner(2, n) = hessian.topRightCorner(n, 2).transpose();
    hessian.bottomRightCorner(2, 2) << sum.sigma_sigma, sum.sigma_kappa, sum.sigma_kappa,
        sum.kappa_kappa;
    model.gradient *= fraction;
    hessian *= fraction;
    return model;
  };
}

Box emg_box(const ScaledLaw& law, double min_sigma) {
  constexpr double widest = 1e9;  // sigma, and the exponential in units of sigma
  const Index n = law.size();
  Box box{VectorXd(n + 2), VectorXd(n + 2)};
  box.low << law.box.low, std::log(min_sigma), -std::log(widest);
  box.high << law.box.high, std::log(std::max(widest, 2 * min_sigma)), std::log(largest_kappa);
  return box;
}

EmgEstimate emg_fit(const ScaledLaw& law, const VectorXd& target, double min_sigma, bool relative,
                    const Estimate& squares, const Estimate& bound,
                    const std::function<Watch(int start)>& watch) {
  const VectorXd above_squares = target - law.curve(squares.x).values;
  const VectorXd above_bound = target - law.curve(bound.x).values;
  const auto at_least = [&](double width) { return std::max(width, min_sigma); };
  const double excess = at_least(above_bound.mean());
  const Widths moments = widths_of(above_squares);
  const double deviation = at_least(std::hypot(moments.exponential, moments.gaussian));
  std::vector<VectorXd> starts;
  starts.push_back(joined(bound.x, at_least(0.1 * excess), at_least(0.1 * excess) / excess));
  const Estimate lowered = least_squares(law, target.array() - moments.exponential);
  starts.push_back(joined(lowered.x, at_least(moments.gaussian),
                          at_least(moments.gaussian) / at_least(moments.exponential)));
  starts.push_back(joined(squares.x, deviation, 3));
  // Few features have several maxima: the more of the excess is error, the higher the curve.
  for (const double fraction : {0.0, 0.25, 0.5, 0.75}) {
    const VectorXd x = bound.x + fraction * (squares.x - bound.x);
    starts.push_back(
        joined(x, at_least(std::max(fraction, 0.5) * excess), std::max(2 * fraction, 0.5)));
  }
  starts.push_back(joined(bound.x, min_sigma, min_sigma / excess));

  const Objective objective = emg_objective(law, target, relative);
  const Box box = emg_box(law, min_sigma);
  EmgEstimate estimate;
  estimate.best.at.value = std::numeric_limits<double>::infinity();
  for (std::size_t start = 0; start < starts.size(); ++start) {
    NewtonOptions options;
    if (watch) options.watch = watch(static_cast<int>(start));
    const BoundedMinimum found = minimise(objective, starts[start], box, options);
    estimate.iterations += found.iterations;
    // A lower value that is rounding does not make up for a search that did not end.
    const double rounding = 1e-12 * (1 + std::abs(found.at.value));
    const bool better = found.converged && !estimate.best.converged
                            ? found.at.value <= estimate.best.at.value + rounding
                            : found.at.value < estimate.best.at.value;
    if (found.gradient == found.gradient && better) estimate.best = found;
  }
  return estimate;
}

}  // namespace carillon::eval::damping
