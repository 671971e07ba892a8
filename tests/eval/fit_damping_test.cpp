#include "eval/damping/fit_damping.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/eval/drawn_features.hpp"

namespace carillon::eval {
namespace {

constexpr double kHertz[] = {500, 2000, 8000};

/// Relative errors of the fitted decay rate at three frequencies.
struct Errors {
  std::vector<double> bias = {0, 0, 0};
  double median = 0;  ///< of absolute errors at the lowest
};

Errors errors_of(const Draw& draw, Estimator estimator, std::uint64_t repetitions) {
  Errors errors;
  std::vector<double> absolute;
  for (std::uint64_t repetition = 0; repetition < repetitions; ++repetition) {
    const DampingFit fit =
        fit_damping(drawn_features(draw, repetition), {}, {estimator, false, false});
    EXPECT_TRUE(fit.converged) << repetition;
    const auto c = synth::damping_function(fit.model);
    for (std::size_t i = 0; i < 3; ++i) {
      const double omega = 2 * std::numbers::pi * kHertz[i];
      const double error = c(omega * omega) / 2 / true_decay_rate(kHertz[i]) - 1;
      errors.bias[i] += error / static_cast<double>(repetitions);
      if (i == 0) absolute.push_back(std::abs(error));
    }
  }
  std::sort(absolute.begin(), absolute.end());
  errors.median = absolute[absolute.size() / 2];
  return errors;
}

/// Percent at 500 Hz, 2 kHz and 8 kHz.
void expect_bias(const Draw& draw, Estimator estimator, const std::vector<double>& percent,
                 double tolerance) {
  const Errors errors = errors_of(draw, estimator, 200);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(100 * errors.bias[i], percent[i], tolerance)
        << draw.points << " points, sigma " << draw.sigma << ", tau " << draw.tau << ", "
        << kHertz[i] << " Hz";
  }
}

// What is asked of the estimators: where least squares is +190 % at 500 Hz, EMG is within 10 %.
TEST(FitDamping, OfThirtyFeaturesIsWithinATenthWhereLeastSquaresIsThreefold) {
  const Errors emg = errors_of({30, 1, 10}, Estimator::emg, 200);
  EXPECT_LT(std::abs(emg.bias[0]), 0.1);
  EXPECT_NEAR(errors_of({30, 1, 10}, Estimator::least_squares, 200).bias[0], 1.9, 0.1);
}

// Bias of 200 repetitions of SciPy's NNLS, linear program and L-BFGS-B on draws of the same law,
// but other draws: they differ by their spread, a few percent (more for few features).
TEST(FitDamping, HasTheBiasOfSciPysEstimators) {
  using enum Estimator;
  expect_bias({100, 1, 10}, least_squares, {195, 123, 18}, 5);
  expect_bias({100, 1, 10}, lower_bound, {-16, -10, -2}, 3);
  expect_bias({100, 1, 10}, emg, {1, 1, 0}, 3);
  expect_bias({30, 1, 10}, least_squares, {191, 121, 17}, 8);
  expect_bias({30, 1, 10}, lower_bound, {3, 2, 0}, 8);
  expect_bias({30, 1, 10}, emg, {6, 4, 1}, 6);
  expect_bias({15, 1, 10}, least_squares, {187, 118, 17}, 12);
  expect_bias({15, 1, 10}, lower_bound, {9, 6, 2}, 10);
  expect_bias({15, 1, 10}, emg, {10, 8, 2}, 10);
  expect_bias({30, 1, 1}, least_squares, {19, 12, 2}, 3);
  expect_bias({30, 1, 1}, lower_bound, {-22, -14, -2}, 6);
  expect_bias({30, 1, 1}, emg, {4, 3, 0}, 3);
  expect_bias({30, 3, 40}, least_squares, {738, 467, 71}, 40);
  expect_bias({30, 3, 40}, emg, {19, 14, 4}, 15);
  expect_bias({30, 2, 0}, least_squares, {0, 0, 0}, 2);
  expect_bias({30, 2, 0}, lower_bound, {-68, -43, -6}, 6);
  expect_bias({30, 2, 0}, emg, {-10, -6, -1}, 4);
}

}  // namespace
}  // namespace carillon::eval
