#include "eval/damping/fit_damping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/damping/detail/check_data.hpp"
#include "eval/damping/detail/confidence.hpp"
#include "eval/damping/detail/emg_fit.hpp"
#include "eval/damping/detail/mixture_fit.hpp"
#include "eval/damping/detail/remarks.hpp"

namespace carillon::eval::damping {

namespace {

using Eigen::Index;
using Eigen::VectorXd;
using synth::damping::DampingKind;

using core::infinity;

/// One fit's work: the data in the law's units.
struct Work {
  const DampingData& data;
  const DampingLaw& law;
  const FitOptions& options;
  ScaledLaw scaled;
  VectorXd target;       ///< c / scale
  double min_sigma = 0;  ///< in the same unit
  double points() const { return static_cast<double>(target.size()); }
  bool relative() const { return is_in_proportion(options.estimator); }
};

/// The features' own error. Without it likelihoods get corners at every curve through some points
/// as sigma shrinks, and grow without end where all points lie on one.
double min_sigma(const DampingData& data, bool relative) {
  if (relative) {
    std::vector<double> fractions;
    for (std::size_t i = 0; i < data.errors.size(); ++i) {
      fractions.push_back(data.errors[i] / data.coefficients[i]);
    }
    return fractions.empty() ? 0.01 : std::max(core::median(fractions), 1e-6);
  }
  const double c = core::median(data.coefficients);
  if (data.errors.empty()) return 0.01 * c;
  return std::max(core::median(data.errors), 1e-6 * c);
}

Work prepare(const DampingData& data, const DampingLaw& law, const FitOptions& options) {
  Work work{data, law, options, scaled_law(law, data), {}, 0};
  work.target =
      Eigen::Map<const VectorXd>(data.coefficients.data(), Index(data.size())) / work.scaled.scale;
  const double unit = work.relative() ? 1 : work.scaled.scale;
  work.min_sigma = min_sigma(data, work.relative()) / unit;
  if (law.kind == DampingKind::expression && !work.scaled.is_linear()) {
    work.scaled = settled_law(work.scaled, work.target, [&](const std::vector<double>& near) {
      return scaled_law(law, data, {}, near);
    });
  }
  return work;
}

/// The excess that the last four numbers of a mixture stand for, in the data's units.
std::vector<ExcessPart> excess_of(const Work& work, const VectorXd& x) {
  const Index n = work.scaled.size();
  const double scale = work.scaled.scale, share = 1 / (1 + std::exp(-x[n + 3]));
  std::vector<ExcessPart> parts = {{share, scale * std::exp(x[n + 1])},
                                   {1 - share, scale * std::exp(x[n + 2])}};
  if (parts[0].mean < parts[1].mean) std::swap(parts[0], parts[1]);
  return parts;
}

double mean_excess(const std::vector<ExcessPart>& parts) {
  return parts[0].share * parts[0].mean + parts[1].share * parts[1].mean;
}

/// Keeps the steps of one start, in the data's units.
Watch keep_steps(const Work& work, int start, std::vector<FitStep>& history) {
  if (!work.options.history) return {};
  return [&work, start, &history](const VectorXd& x, double value, double gradient) {
    const Index n = work.scaled.size();
    FitStep step;
    step.start = start;
    step.gradient = gradient;
    step.parameters = work.scaled.alphas(x.head(n));
    const double scale = work.scaled.scale;
    switch (work.options.estimator) {
      case Estimator::mixture:
        step.log_likelihood = -work.points() * (value + std::log(scale));
        step.parameters.push_back(std::exp(x[n]));
        step.parameters.push_back(1 / mean_excess(excess_of(work, x)));
        break;
      case Estimator::emg:
      case Estimator::emg_relative:
        step.log_likelihood = -work.points() * (value + std::log(scale));
        step.parameters.push_back((work.relative() ? 1 : scale) * std::exp(x[n]));
        step.parameters.push_back(std::exp(x[n + 1] - x[n]) / scale);
        break;
      case Estimator::least_squares:
        step.log_likelihood = -value * scale * scale;
        break;
      case Estimator::lower_bound:
        step.log_likelihood = -value * scale;
    }
    history.push_back(std::move(step));
  };
}

/// The law with a parameter that stands for one alpha alone.
ScaledLaw law_along(const Work& work, std::size_t alpha, const std::vector<double>& alphas) {
  return scaled_law(work.law, work.data, alpha, alphas);
}

DampingFit begin_fit(const Work& work, const VectorXd& x, bool converged, int iterations) {
  DampingFit fit;
  fit.estimator = work.options.estimator;
  fit.model = {work.law.kind, work.scaled.alphas(x), work.law.expression};
  fit.points = work.data.size();
  fit.converged = converged;
  fit.iterations = iterations;
  return fit;
}

double mean_square(const Work& work, const VectorXd& x) {
  return (work.target - work.scaled.curve(x).values).squaredNorm() / work.points();
}

/// Sets sigma, eta and the likelihood of a Gaussian about the curve.
void set_gaussian(DampingFit& fit, const Work& work, double misfit) {
  const double sigma = std::max(std::sqrt(misfit), work.min_sigma);
  fit.sigma = sigma * work.scaled.scale;
  fit.eta = infinity;
  fit.log_likelihood =
      -work.points() *
      (std::log(fit.sigma) + 0.5 * std::log(2 * std::numbers::pi) + misfit / (2 * sigma * sigma));
}

DampingFit fit_least_squares(const Work& work) {
  std::vector<FitStep> history;
  const Estimate found = least_squares(work.scaled, work.target, keep_steps(work, 0, history));
  DampingFit fit = begin_fit(work, found.x, found.converged, found.iterations);
  fit.history = std::move(history);
  const double misfit = mean_square(work, found.x);
  set_gaussian(fit, work, misfit);
  if (!work.options.confidence) return fit;
  const std::size_t n = fit.model.parameters.size();
  if (fit.points <= n) {
    fit.confidence95.assign(n, {-infinity, infinity});
    return fit;
  }
  // Student's quantile makes the interval exact for a linear law.
  const double freedom = work.points() - static_cast<double>(n);
  const double t = boost::math::quantile(boost::math::students_t(freedom), 0.975);
  const double sigma = fit.sigma / work.scaled.scale;
  const double unit = work.points() * sigma * sigma;
  for (std::size_t k = 0; k < n; ++k) {
    const ScaledLaw law = law_along(work, k, fit.model.parameters);
    const Likelihood likelihood{misfit_objective(law, work.target, unit), law.box,
                                law.parameters(fit.model.parameters), freedom};
    fit.confidence95.push_back(profile_interval(law, likelihood, k, t * t / 2));
  }
  return fit;
}

DampingFit fit_lower_bound(const Work& work) {
  std::vector<FitStep> history;
  const Estimate found =
      lower_bound(work.scaled, work.target, nullptr, keep_steps(work, 0, history));
  DampingFit fit = begin_fit(work, found.x, found.converged, found.iterations);
  fit.history = std::move(history);
  const double excess = (work.target - work.scaled.curve(found.x).values).mean();
  const double mean = std::max(excess, work.min_sigma) * work.scaled.scale;
  fit.eta = excess > work.min_sigma ? 1 / mean : infinity;
  fit.log_likelihood = -work.points() * (std::log(mean) + excess * work.scaled.scale / mean);
  if (work.options.confidence) {
    fit.confidence95 = lower_bound_intervals(work.scaled, work.target, found.x);
  }
  return fit;
}

/// 95 % of chi-squared of one degree of freedom.
constexpr double likelihood_drop = 3.841458820694124 / 2;

void emg_intervals(DampingFit& fit, const Work& work, double log_sigma, double log_kappa) {
  for (std::size_t k = 0; k < fit.model.parameters.size(); ++k) {
    const ScaledLaw law = law_along(work, k, fit.model.parameters);
    VectorXd best(law.size() + 2);
    best << law.parameters(fit.model.parameters), log_sigma, log_kappa;
    const Likelihood likelihood{emg_objective(law, work.target, work.relative()),
                                emg_box(law, work.min_sigma), best, work.points()};
    fit.confidence95.push_back(profile_interval(law, likelihood, k, likelihood_drop));
  }
}

DampingFit fit_emg(const Work& work) {
  std::vector<FitStep> history;
  const Estimate squares = least_squares(work.scaled, work.target);
  const Estimate bound = lower_bound(work.scaled, work.target, &squares.x);
  const EmgEstimate found =
      emg_fit(work.scaled, work.target, work.min_sigma, work.relative(), squares, bound,
              [&](int start) { return keep_steps(work, start, history); });
  const Index n = work.scaled.size();
  if (found.best.x.size() == 0) {
    throw core::SolverError("no curve of this law has a finite likelihood",
                            "try another --model or --estimator lower_bound");
  }
  VectorXd x = found.best.x.head(n);
  double log_sigma = found.best.x[n];
  double log_kappa = found.best.x[n + 1];
  DampingFit gaussian = begin_fit(work, squares.x, squares.converged, squares.iterations);
  set_gaussian(gaussian, work, mean_square(work, squares.x));
  const double log_likelihood =
      -work.points() * (found.best.at.value + std::log(work.scaled.scale));
  // Without excess the likelihood rises ever more slowly towards a Gaussian.
  const bool relative = work.relative();
  const bool no_excess =
      !relative && log_likelihood < gaussian.log_likelihood + 1e-6 * work.points();

  DampingFit fit = begin_fit(work, no_excess ? squares.x : x, found.best.converged || no_excess,
                             found.iterations);
  fit.history = std::move(history);
  if (no_excess) {
    fit.sigma = gaussian.sigma;
    fit.eta = infinity;
    fit.log_likelihood = gaussian.log_likelihood;
    log_sigma = std::log(gaussian.sigma / work.scaled.scale);
    log_kappa = std::log(largest_kappa);
  } else {
    const double sigma = std::exp(log_sigma) * work.scaled.scale;  // where c is of one unit
    fit.sigma = relative ? std::exp(log_sigma) : sigma;
    fit.eta = std::exp(log_kappa) / sigma;
    if (log_kappa > std::log(0.99 * largest_kappa)) fit.eta = infinity;
    fit.log_likelihood = log_likelihood;
  }
  if (work.options.confidence) emg_intervals(fit, work, log_sigma, log_kappa);
  add_emg_remarks(fit, gaussian, work.data, min_sigma(work.data, relative));
  return fit;
}

DampingFit fit_mixture(const Work& work) {
  std::vector<FitStep> history;
  const std::vector<Observed> points = observed_points(work.data, work.scaled.scale);
  const Estimate squares = least_squares(work.scaled, work.target);
  const Estimate bound = lower_bound(work.scaled, work.target, &squares.x);
  const MixtureEstimate found =
      mixture_fit(work.scaled, work.target, points, squares, bound,
                  [&](int start) { return keep_steps(work, start, history); });
  const Index n = work.scaled.size();
  if (found.best.x.size() == 0) {
    throw core::SolverError("no curve of this law has a finite likelihood",
                            "try another --model or --estimator lower_bound");
  }
  const VectorXd& x = found.best.x;
  DampingFit fit = begin_fit(work, x.head(n), found.best.converged, found.iterations);
  fit.history = std::move(history);
  fit.sigma = std::exp(x[n]);
  fit.excess = excess_of(work, x);
  fit.eta = 1 / mean_excess(fit.excess);
  fit.log_likelihood =
      mixture_log_likelihood(work.scaled, points, x) - work.points() * std::log(work.scaled.scale);
  const VectorXd outliers = outlier_probabilities(work.scaled, points, x);
  fit.outliers = std::size_t((outliers.array() > 0.5).count());
  if (work.options.confidence) {
    for (std::size_t k = 0; k < fit.model.parameters.size(); ++k) {
      const ScaledLaw law = law_along(work, k, fit.model.parameters);
      VectorXd best(n + 4);
      best << law.parameters(fit.model.parameters), x.tail(4);
      const Likelihood likelihood{mixture_objective(law, points), mixture_box(law), best,
                                  work.points()};
      fit.confidence95.push_back(profile_interval(law, likelihood, k, likelihood_drop));
    }
  }
  add_outlier_remark(fit, work.data, outliers);
  return fit;
}

}  // namespace

DampingFit fit_damping(const DampingData& data, const DampingLaw& law, const FitOptions& options) {
  check_data(data, law, options.estimator);
  const Work work = prepare(data, law, options);
  DampingFit fit = options.estimator == Estimator::least_squares ? fit_least_squares(work)
                   : options.estimator == Estimator::lower_bound ? fit_lower_bound(work)
                   : options.estimator == Estimator::mixture     ? fit_mixture(work)
                                                                 : fit_emg(work);
  add_remarks(fit, data);
  return fit;
}

}  // namespace carillon::eval::damping
