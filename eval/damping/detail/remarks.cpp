#include "eval/damping/detail/remarks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "eval/damping/detail/information.hpp"
#include "eval/damping/detail/scaled_law.hpp"

namespace carillon::eval::damping {

namespace {

using synth::damping::DampingKind;

/// Skewness of what is left of the points about a model, in its standard errors.
double skewness(const DampingData& data, const synth::damping::DampingModel& model) {
  const std::vector<double> c = synth::damping::damping_coefficients(model, data.eigenvalues);
  const double n = static_cast<double>(data.size());
  double mean = 0, square = 0, cube = 0;
  for (std::size_t i = 0; i < data.size(); ++i) mean += (data.coefficients[i] - c[i]) / n;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const double rest = data.coefficients[i] - c[i] - mean;
    square += rest * rest / n;
    cube += rest * rest * rest / n;
  }
  return square > 0 ? cube / std::pow(square, 1.5) / std::sqrt(6 / n) : 0;
}

}  // namespace

NegativeBand negative_band(const synth::damping::DampingModel& model, const DampingData& data) {
  constexpr int places = 400;
  const auto [low, high] = std::minmax_element(data.eigenvalues.begin(), data.eigenvalues.end());
  const auto c = synth::damping::damping_function(model);
  NegativeBand band;
  for (int i = 0; i < places; ++i) {
    const double lambda = *low * std::pow(*high / *low, i / (places - 1.0));
    if (!(c(lambda) < 0)) continue;
    const double f = std::sqrt(lambda) / (2 * std::numbers::pi);
    if (!band.is) band.low = f;
    band.is = true;
    band.high = f;
  }
  return band;
}

void add_remarks(DampingFit& fit, const DampingData& data) {
  const auto& alphas = fit.model.parameters;
  if (const NegativeBand band = negative_band(fit.model, data); band.is) {
    fit.remarks.push_back(fmt::format(
        "the law is negative from {:.0f} to {:.0f} Hz, within the features' band: no sound can be "
        "made with it; --model hybrid or rayleigh stay positive",
        band.low, band.high));
  }
  if (!fit.converged) {
    fit.remarks.push_back("the search did not end at a maximum: the parameters are its best");
  }
  const bool bounded =
      fit.model.kind == DampingKind::rayleigh || fit.model.kind == DampingKind::hybrid;
  for (std::size_t k = 0; bounded && k < 2; ++k) {
    if (alphas[k] > 0) continue;
    fit.remarks.push_back(fmt::format(
        "{} is 0: the data would have it negative{}", synth::damping::parameter_name(k),
        fit.model.kind == DampingKind::hybrid && k == 1 ? "; alpha3 then means nothing" : ""));
  }
  const bool exponent =
      fit.model.kind == DampingKind::power || fit.model.kind == DampingKind::hybrid;
  if (exponent && std::abs(alphas.back()) >= largest_exponent) {
    fit.remarks.push_back(fmt::format("{} is at the end of what is searched, {} to {}",
                                      synth::damping::parameter_name(alphas.size() - 1),
                                      -largest_exponent, largest_exponent));
  }
  if (fit.estimator == Estimator::least_squares && fit.points == alphas.size()) {
    fit.remarks.push_back("as many points as parameters: nothing is known of their errors");
  }
}

void add_emg_remarks(DampingFit& fit, const DampingFit& gaussian, const DampingData& data,
                     double min_sigma) {
  DampingFit squares = gaussian;
  squares.estimator = Estimator::least_squares;
  const bool relative = fit.estimator == Estimator::emg_relative;
  if (std::isinf(fit.eta)) {
    fit.remarks.push_back(relative ? "no excess damping can be seen"
                                   : "no excess damping can be seen: the result is that of least "
                                     "squares");
  } else if (const double here = akaike(fit), there = akaike(squares);
             std::isfinite(here) && there <= here) {
    fit.remarks.push_back(fmt::format(
        "least squares is enough: its AIC is {:.1f}, that of the EMG {:.1f}", there, here));
  }
  if (skewness(data, gaussian.model) < -2.5) {
    fit.remarks.push_back(
        "more points lie far below the curve than far above: reverberation, clipping or beating "
        "rather than supports; the model cannot tell them from the material");
  }
  if (fit.sigma <= 1.0001 * min_sigma) {
    fit.remarks.push_back(fmt::format("sigma is at its lower bound, {:.3g}{} ({})", min_sigma,
                                      relative ? " of c" : " 1/s",
                                      !data.errors.empty() ? "the median error of the features"
                                      : relative           ? "without errors of the features"
                                                           : "1 % of the median c"));
  }
}

void add_outlier_remark(DampingFit& fit, const DampingData& data,
                        const Eigen::VectorXd& probabilities) {
  if (fit.outliers == 0) return;
  const auto law = synth::damping::damping_coefficients(fit.model, data.eigenvalues);
  std::size_t farthest = 0;
  double distance = -1;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const double away = std::abs(std::log(data.coefficients[i] / std::max(law[i], 1e-300)));
    if (probabilities[Eigen::Index(i)] <= 0.5 || away <= distance) continue;
    farthest = i;
    distance = away;
  }
  const double d = data.coefficients[farthest] / 2;
  const double omega = std::sqrt(std::max(0.0, data.eigenvalues[farthest] - d * d));
  fit.remarks.push_back(fmt::format(
      "{} of {} features look like outliers and hardly count; the farthest is that of {:.1f} Hz, d "
      "= {:.4g} 1/s where the law has {:.4g}",
      fit.outliers, fit.points, omega / (2 * std::numbers::pi), d, law[farthest] / 2));
}

}  // namespace carillon::eval::damping
