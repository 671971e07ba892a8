#include "eval/damping/detail/mixture_fit.hpp"

#include <algorithm>
#include <cmath>

#include "core/numbers.hpp"

namespace carillon::eval::damping {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector4d;
using Eigen::VectorXd;

constexpr Index numbers = mixture_place::count - 1;

/// A law's value where it is used as a size: what is nearly zero or negative stays positive.
MixtureJet positive(double value) {
  constexpr double smallest = 1e-6;  // in units of the law's scale
  if (value >= smallest) return {value, MixtureJet::variable(0, 0).first};
  const double away = 2 * smallest - value, fraction = smallest / away;
  MixtureJet jet{smallest * fraction};
  jet.first[0] = fraction * fraction;
  jet.second(0, 0) = 2 * jet.first[0] / away;
  return jet;
}

/// Derivatives by the law's value instead of by what positive() made of it.
void follow(MixtureJet& density, const MixtureJet& size) {
  const double slope = size.first[0];
  if (slope == 1) return;
  density.second.row(0) *= slope;
  density.second.col(0) *= slope;
  density.second(0, 0) += density.first[0] * size.second(0, 0);
  density.first[0] *= slope;
}

struct Prior {
  double value = 0;
  Vector4d slope, bend;
};

/// ln of the priors, each number's own.
Prior prior_at(const Vector4d& x) {
  const Vector4d middle(std::log(0.01), 0, 0, 0), width(1.5, 4, 4, 1);
  Prior prior;
  prior.slope = (middle - x).cwiseQuotient(width.cwiseAbs2());
  prior.bend = -width.cwiseAbs2().cwiseInverse();
  prior.value = -(x - middle).head(3).cwiseQuotient(width.head(3)).squaredNorm() / 2;
  // Beta(2, 2) of w: ln w + ln(1 - w).
  const double w = 1 / (1 + std::exp(-x[3]));
  prior.value += std::log(w) + std::log1p(-w);
  prior.slope[3] = 1 - 2 * w;
  prior.bend[3] = -2 * w * (1 - w);
  return prior;
}

VectorXd joined(const VectorXd& x, double sigma, double touched, double spared) {
  VectorXd all(x.size() + numbers);
  all << x, std::log(sigma), std::log(touched), std::log(spared), 0;
  return all;
}

/// Least squares of relative errors.
VectorXd relative_squares(const ScaledLaw& law, const VectorXd& target) {
  const VectorXd inverse = target.cwiseInverse();
  ScaledLaw weighed = law;
  weighed.curve = [&](const VectorXd& x) {
    Curve curve = law.curve(x);
    curve.values = curve.values.cwiseProduct(inverse);
    curve.slopes = inverse.asDiagonal() * curve.slopes;
    return curve;
  };
  if (law.bend) {
    weighed.bend = [&](const VectorXd& x, const VectorXd& weights) {
      return law.bend(x, weights.cwiseProduct(inverse));
    };
  }
  return least_squares(weighed, VectorXd::Ones(target.size())).x;
}

/// Some of the points of a law and of what it is fitted to, evenly taken.
struct Sample {
  ScaledLaw law;
  std::vector<Observed> points;
};
Sample sample_of(const ScaledLaw& law, const std::vector<Observed>& points, std::size_t maximum) {
  if (points.size() <= maximum) return {law, points};
  std::vector<Index> rows;
  Sample sample{law, {}};
  for (std::size_t k = 0; k < maximum; ++k) {
    rows.push_back(Index(k * points.size() / maximum));
    sample.points.push_back(points[std::size_t(rows.back())]);
  }
  sample.law.curve = [&law, rows](const VectorXd& x) {
    const Curve curve = law.curve(x);
    return Curve{curve.values(rows), curve.slopes(rows, Eigen::all)};
  };
  if (law.bend) {
    sample.law.bend = [&law, rows, n = Index(points.size())](const VectorXd& x,
                                                             const VectorXd& weights) {
      VectorXd all = VectorXd::Zero(n);
      all(rows) = weights;
      return law.bend(x, all);
    };
  }
  return sample;
}

std::vector<VectorXd> starts_of(const ScaledLaw& law, const VectorXd& target,
                                const VectorXd& squares, const VectorXd& bound) {
  std::vector<VectorXd> curves;
  for (const double fraction : {0.0, 0.5, 1.0}) {
    curves.push_back(bound + fraction * (squares - bound));
  }
  curves.push_back(relative_squares(law, target));
  std::vector<VectorXd> starts;
  for (const VectorXd& x : curves) {
    const VectorXd rest = (target - law.curve(x).values).cwiseMax(0);
    const double excess = std::clamp(rest.mean(), 1e-3, 1e3);
    starts.push_back(joined(x, 0.01, 2 * excess, 0.1 * excess));
    starts.push_back(joined(x, 0.1, 2 * excess, 0.1 * excess));
  }
  return starts;
}

}  // namespace

std::vector<Observed> observed_points(const DampingData& data, double scale) {
  std::vector<Observed> points(data.size());
  for (std::size_t i = 0; i < data.size(); ++i) {
    points[i].c = data.coefficients[i] / scale;
    if (!data.errors.empty()) points[i].error = data.errors[i] / scale;
    if (!data.proportions.empty() && data.proportions[i] > 0) {
      points[i].proportion = data.proportions[i];
      points[i].error = 0;
    }
    if (!data.ceilings.empty()) points[i].ceiling = data.ceilings[i] / scale;
  }
  return points;
}

Objective mixture_objective(const ScaledLaw& law, const std::vector<Observed>& points) {
  return [&law, &points](const VectorXd& all) {
    const Index n = law.size();
    const auto count = Index(points.size());
    const Vector4d at = all.tail(numbers);
    const Curve curve = law.curve(all.head(n));
    VectorXd by_law(count), by_law_twice(count);
    MatrixXd mixed(count, numbers);
    const Prior prior = prior_at(at);
    double value = prior.value;
    Vector4d slope = prior.slope;
    Eigen::Matrix4d bend = prior.bend.asDiagonal();
    for (Index i = 0; i < count; ++i) {
      const MixtureJet size = positive(curve.values[i]);
      MixtureJet f = mixture_log_density(points[std::size_t(i)], size.value, at);
      follow(f, size);
      value += f.value;
      slope += f.first.tail(numbers);
      bend += f.second.bottomRightCorner(numbers, numbers);
      by_law[i] = f.first[0];
      by_law_twice[i] = f.second(0, 0);
      mixed.row(i) = f.second.row(0).tail(numbers);
    }
    const double fraction = -1 / static_cast<double>(count);
    LocalModel model{fraction * value, VectorXd(n + numbers), MatrixXd(n + numbers, n + numbers)};
    model.gradient << curve.slopes.transpose() * by_law, slope;
    MatrixXd& hessian = model.hessian;
    hessian.topLeftCorner(n, n) =
        curve.slopes.transpose() * by_law_twice.asDiagonal() * curve.slopes;
    if (law.bend) hessian.topLeftCorner(n, n) += law.bend(all.head(n), by_law);
    hessian.topRightCorner(n, numbers) = curve.slopes.transpose() * mixed;
    hessian.bottomLeftCorner(numbers, n) = hessian.topRightCorner(n, numbers).transpose();
    hessian.bottomRightCorner(numbers, numbers) = bend;
    model.gradient *= fraction;
    hessian *= fraction;
    return model;
  };
}

Box mixture_box(const ScaledLaw& law) {
  const Index n = law.size();
  Box box{VectorXd(n + numbers), VectorXd(n + numbers)};
  box.low << law.box.low, std::log(min_proportion), std::log(1e-5), std::log(1e-5), -20;
  box.high << law.box.high, 0, std::log(1e6), std::log(1e6), 20;
  return box;
}

double mixture_log_likelihood(const ScaledLaw& law, const std::vector<Observed>& points,
                              const VectorXd& x) {
  const VectorXd values = law.curve(x.head(law.size())).values;
  const Vector4d at = x.tail(numbers);
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    sum += mixture_log_density(points[i], positive(values[Index(i)]).value, at).value;
  }
  return sum;
}

VectorXd outlier_probabilities(const ScaledLaw& law, const std::vector<Observed>& points,
                               const VectorXd& x) {
  const VectorXd values = law.curve(x.head(law.size())).values;
  VectorXd probabilities(values.size());
  for (Index i = 0; i < values.size(); ++i) {
    probabilities[i] =
        outlier_probability(points[std::size_t(i)], positive(values[i]).value, x.tail(numbers));
  }
  return probabilities;
}

MixtureEstimate mixture_fit(const ScaledLaw& law, const VectorXd& target,
                            const std::vector<Observed>& points, const Estimate& squares,
                            const Estimate& bound, const std::function<Watch(int start)>& watch) {
  constexpr std::size_t tried_points = 500, kept = 3;
  const Sample sample = sample_of(law, points, tried_points);
  const Box box = mixture_box(law);
  const Objective tried = mixture_objective(sample.law, sample.points);
  MixtureEstimate estimate;
  std::vector<BoundedMinimum> found;
  for (const VectorXd& start : starts_of(law, target, squares.x, bound.x)) {
    NewtonOptions options;
    options.tolerance = 1e-6;
    options.max_iterations = 60;
    found.push_back(minimise(tried, start, box, options));
    estimate.iterations += found.back().iterations;
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::isfinite(a.at.value) && !(b.at.value <= a.at.value);
  });
  const Objective objective = mixture_objective(law, points);
  estimate.best.at.value = core::infinity;
  int number = 0;
  std::vector<double> ends;
  for (const BoundedMinimum& start : found) {
    if (number == int(kept)) break;
    // Starts that met are one.
    const auto same = [&](double end) { return std::abs(end - start.at.value) < 1e-5; };
    if (std::any_of(ends.begin(), ends.end(), same)) continue;
    ends.push_back(start.at.value);
    NewtonOptions options;
    if (watch) options.watch = watch(number);
    const BoundedMinimum end = minimise(objective, start.x, box, options);
    estimate.iterations += end.iterations;
    ++number;
    if (end.at.value < estimate.best.at.value) estimate.best = end;
  }
  return estimate;
}

}  // namespace carillon::eval::damping
