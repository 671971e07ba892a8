// The mixture's density by integration and by differences; what it finds in drawn features.
#include "eval/damping/detail/mixture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/numbers.hpp"
#include "core/random.hpp"
#include "eval/damping/detail/mixture_fit.hpp"
#include "eval/damping/law_text.hpp"

namespace carillon::eval::damping {
namespace {

Eigen::Vector4d numbers_of(double s, double t1, double t2, double w) {
  return {std::log(s), std::log(t1), std::log(t2), std::log(w / (1 - w))};
}

/// Simpson's rule.
template <class F>
double integral(F f, double low, double high, int steps = 20000) {
  const double h = (high - low) / steps;
  double sum = f(low) + f(high);
  for (int i = 1; i < steps; ++i) sum += f(low + i * h) * (i % 2 == 1 ? 4 : 2);
  return sum * h / 3;
}

TEST(Mixture, IsTheIntegralOfItsDefinition) {
  const double m = 12, s = 0.03, error = 0.4, t1 = 7, t2 = 0.5, w = 0.3;
  const double sigma = std::hypot(s * m, error);
  for (const double c : {10.5, 11.9, 12.3, 14.0, 40.0}) {
    const auto inlier = [&](double excess) {
      const double u = (c - m - excess) / sigma;
      return std::exp(-u * u / 2) / (sigma * std::sqrt(2 * std::numbers::pi)) *
             (w / t1 * std::exp(-excess / t1) + (1 - w) / t2 * std::exp(-excess / t2));
    };
    const double density =
        (1 - outlier_share) * integral(inlier, 0, 60) + outlier_share * m / std::pow(c + m, 2);
    EXPECT_NEAR(mixture_log_density({c, error}, m, numbers_of(s, t1, t2, w)).value,
                std::log(density), 1e-9)
        << c;
  }
}

TEST(Mixture, AProportionIsAnErrorOfTheLawsValue) {
  const auto numbers = numbers_of(0.03, 7, 0.5, 0.3);
  for (const double m : {4.0, 12.0}) {
    Observed in_proportion{10.5}, absolute{10.5, 0.2 * m};
    in_proportion.proportion = 0.2;
    const MixtureJet relative = mixture_log_density(in_proportion, m, numbers);
    const MixtureJet known = mixture_log_density(absolute, m, numbers);
    EXPECT_NEAR(relative.value, known.value, 1e-12) << m;
    // The error grows with the law.
    const double h = 1e-5;
    const double slope = (mixture_log_density(in_proportion, m + h, numbers).value -
                          mixture_log_density(in_proportion, m - h, numbers).value) /
                         (2 * h);
    EXPECT_NEAR(relative.first[0], slope, 1e-7) << m;
    EXPECT_GT(std::abs(relative.first[0] - known.first[0]), 1e-3) << m;
  }
}

TEST(Mixture, BelowACeilingSumsToOne) {
  for (const double m : {2.0, 12.0, 35.0, 90.0}) {
    const auto numbers = numbers_of(0.05, 6, 0.5, 0.4);
    const double ceiling = 30;
    // Outliers are positive; errors of an inlier may not be.
    const auto density = [&](double c) {
      return std::exp(mixture_log_density({c, 0.1, ceiling}, m, numbers).value);
    };
    EXPECT_NEAR(integral(density, 1e-9, ceiling, 200000), 1, 1e-5) << m;
  }
}

// What is above the ceiling could not be seen, so a law far above it is as likely wherever it is.
TEST(Mixture, AnOutlierFarBelowAHiddenLawSaysNothingOfTheLaw) {
  const auto numbers = numbers_of(0.02, 2, 0.2, 0.5);
  const MixtureJet f = mixture_log_density({20, 0.1, 46}, 4000, numbers);
  EXPECT_NEAR(f.value, -std::log(46), 0.02);  // of 20 or of any other c below it
  EXPECT_LT(std::abs(f.first[mixture_place::law] * 4000), 0.03);
}

TEST(Mixture, HasExactDerivatives) {
  core::RandomStream random(5, 0, "test.mixture");
  for (int trial = 0; trial < 60; ++trial) {
    const double m = random.log_uniform(0.5, 50);
    const Observed seen{m * random.log_uniform(0.7, 5), trial % 3 == 0 ? 0 : 0.02 * m,
                        trial % 2 == 0 ? core::infinity : m * 6};
    Eigen::Matrix<double, 5, 1> x;
    x << m, numbers_of(random.log_uniform(0.01, 0.3), m * random.log_uniform(0.1, 3),
                       m * random.log_uniform(0.01, 0.1), random.uniform(0.1, 0.9));
    const auto at = [&](const Eigen::Matrix<double, 5, 1>& y) {
      return mixture_log_density(seen, y[0], y.tail(4));
    };
    const MixtureJet f = at(x);
    for (int i = 0; i < 5; ++i) {
      const double h = 1e-5 * (i == 0 ? m : 1);
      const Eigen::Matrix<double, 5, 1> step = h * Eigen::Matrix<double, 5, 1>::Unit(i);
      const MixtureJet up = at(x + step), down = at(x - step);
      EXPECT_NEAR(f.first[i], (up.value - down.value) / (2 * h), 1e-6 * (1 + std::abs(f.first[i])));
      for (int k = 0; k < 5; ++k) {
        EXPECT_NEAR(f.second(k, i), (up.first[k] - down.first[k]) / (2 * h),
                    2e-5 * (1 + std::abs(f.second(k, i))))
            << trial << ": " << k << ", " << i;
      }
    }
  }
}

TEST(Mixture, ObjectiveHasExactDerivativesWhereTheLawIsNegativeToo) {
  DampingData data;
  core::RandomStream random(6, 0, "test.mixture");
  for (int i = 0; i < 30; ++i) {
    data.eigenvalues.push_back(std::pow(2 * std::numbers::pi * random.uniform(300, 9000), 2));
    data.coefficients.push_back(5 + 4e-8 * data.eigenvalues.back() - std::log(random.uniform()));
    data.errors.push_back(0.1);
    data.ceilings.push_back(i % 2 == 0 ? core::infinity : 500);
  }
  const ScaledLaw law = scaled_law(damping_law("caughey:2"), data);
  const auto points = observed_points(data, law.scale);
  const Objective objective = mixture_objective(law, points);
  for (const double alpha1 : {5.0, -6.0}) {
    Eigen::VectorXd x(6);
    x << law.parameters({alpha1, 4.5e-8}), numbers_of(0.05, 0.3, 0.05, 0.4);
    const LocalModel at = objective(x);
    for (Eigen::Index i = 0; i < 6; ++i) {
      const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(6, i);
      const LocalModel up = objective(x + step), down = objective(x - step);
      EXPECT_NEAR(at.gradient[i], (up.value - down.value) / 2e-6,
                  1e-5 * (1 + std::abs(at.gradient[i])));
      for (Eigen::Index k = 0; k < 6; ++k) {
        EXPECT_NEAR(at.hessian(k, i), (up.gradient[k] - down.gradient[k]) / 2e-6,
                    1e-4 * (1 + std::abs(at.hessian(k, i))));
      }
    }
  }
}

/// Features as supports leave them: the square of a Gaussian mode shape at one place (chi-squared
/// of one degree), times a force of its own for each sound; one in twenty is a doublet's, up to 30
/// % off.
DampingData supported(std::size_t sounds, std::uint64_t seed) {
  core::RandomStream random(8, seed, "test.supported");
  DampingData data;
  for (std::size_t sound = 0; sound < sounds; ++sound) {
    const double force = random.log_uniform(5, 50);
    for (int i = 0; i < 25; ++i) {
      const double lambda = std::pow(2 * std::numbers::pi * random.log_uniform(400, 9000), 2);
      const double law = 4 + 4e-8 * lambda, error = 0.003 * law;
      const double doublet = random.uniform() < 0.05 ? random.uniform(-0.3, 0.3) * law : 0;
      data.eigenvalues.push_back(lambda);
      data.coefficients.push_back(law + force * std::pow(random.normal(), 2) + doublet +
                                  error * random.normal());
      data.errors.push_back(error);
    }
  }
  return data;
}

double median_error(Estimator estimator, std::size_t sounds, int draws) {
  std::vector<double> errors;
  for (int draw = 0; draw < draws; ++draw) {
    const DampingFit fit =
        fit_damping(supported(sounds, std::uint64_t(draw)), {}, {estimator, false, false});
    EXPECT_TRUE(fit.converged) << sounds << ", " << draw;
    errors.push_back(std::abs(fit.model.parameters[0] / 4 - 1));
  }
  return core::median(errors);
}

TEST(Mixture, MoreSoundsHelp) {
  const double one = median_error(Estimator::mixture, 1, 40);
  const double five = median_error(Estimator::mixture, 5, 20);
  const double thirty = median_error(Estimator::mixture, 30, 10);
  EXPECT_LT(five, 0.5 * one);
  EXPECT_LT(thirty, 0.9 * five);
  EXPECT_LT(thirty, 0.01);
  const double emg = median_error(Estimator::emg, 30, 10);
  EXPECT_LT(thirty, 0.25 * emg) << one << ", " << five << ", " << thirty << "; EMG " << emg;
}

// A Rayleigh fit must not be owned by two fast, weak features beside four that are right.
TEST(Mixture, TwoWrongFeaturesDoNotOwnTheFit) {
  for (const double high : {4000.0, 9000.0}) {
    DampingData data;
    for (const double f : {450.0, 800.0, 1500.0, 2600.0}) {
      data.eigenvalues.push_back(std::pow(2 * std::numbers::pi * f, 2));
      data.coefficients.push_back(2 * (5 + 2e-8 * data.eigenvalues.back()));
    }
    for (const double f : {high, 1.1 * high}) {
      data.eigenvalues.push_back(std::pow(2 * std::numbers::pi * f, 2));
      data.coefficients.push_back(2 * 1500);
    }
    const DampingFit fit = fit_damping(data, {}, {Estimator::mixture, true, false});
    EXPECT_NEAR(fit.model.parameters[0], 10, 0.5);
    EXPECT_NEAR(fit.model.parameters[1] / 4e-8, 1, 0.05);
    const DampingFit squares = fit_damping(data, {}, {Estimator::least_squares, false, false});
    EXPECT_EQ(squares.model.parameters[0], 0);
  }
}

TEST(Mixture, TheMoreExactFeatureCountsMore) {
  DampingData data;
  core::RandomStream random(9, 0, "test.mixture");
  for (int i = 0; i < 60; ++i) {
    const bool exact = i % 3 == 0;
    const double lambda = std::pow(2 * std::numbers::pi * random.uniform(400, 6000), 2);
    data.errors.push_back(exact ? 0.02 : 5);
    data.eigenvalues.push_back(lambda);
    data.coefficients.push_back(20 + 4e-8 * lambda + data.errors.back() * random.normal());
  }
  const DampingFit weighed = fit_damping(data, {}, {Estimator::mixture, false, false});
  EXPECT_NEAR(weighed.model.parameters[0] / 20, 1, 0.01);
  data.errors.assign(60, 5);
  const DampingFit alike = fit_damping(data, {}, {Estimator::mixture, false, false});
  EXPECT_GT(std::abs(alike.model.parameters[0] / 20 - 1),
            3 * std::abs(weighed.model.parameters[0] / 20 - 1));
}

// A room shows what decays slower than itself alone: the truncated likelihood knows.
TEST(Mixture, WhatARoomHidesIsAccountedFor) {
  std::vector<double> truncated, plain;
  for (std::uint64_t draw = 0; draw < 20; ++draw) {
    const DampingData all = supported(20, draw);
    DampingData seen;
    const double ceiling = 2 * std::log(1000) / 0.6;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (all.coefficients[i] > ceiling) continue;
      seen.eigenvalues.push_back(all.eigenvalues[i]);
      seen.coefficients.push_back(all.coefficients[i]);
      seen.errors.push_back(all.errors[i]);
    }
    plain.push_back(std::abs(
        fit_damping(seen, {}, {Estimator::emg_relative, false, false}).model.parameters[1] / 4e-8 -
        1));
    seen.ceilings.assign(seen.size(), ceiling);
    truncated.push_back(std::abs(
        fit_damping(seen, {}, {Estimator::mixture, false, false}).model.parameters[1] / 4e-8 - 1));
  }
  EXPECT_LT(core::median(truncated), 0.02);
  EXPECT_LT(core::median(truncated), 0.5 * core::median(plain));
}

// What is fitted to a room's fluctuations is not exact: it is no mode.
TEST(Mixture, WhatIsNotExactInARoomIsLeftOut) {
  std::vector<features::Feature> features(3);
  for (features::Feature& feature : features) {
    feature.frequency = 2000;
    feature.decay_rate = 10;
    feature.decay_rate_error = 0.2;
  }
  features[1].decay_rate_error = 1.5;
  features[2].reverberant = true;
  const double rt60[] = {0.5};
  const DampingData in_room = damping_data(features, rt60);
  ASSERT_EQ(in_room.size(), 1u);
  EXPECT_EQ(in_room.errors[0], 0.4);
  EXPECT_NEAR(in_room.ceilings[0], 2 * std::log(1000) / 0.5, 1e-12);
  const DampingData dry = damping_data(features);
  EXPECT_EQ(dry.size(), 2u);
  EXPECT_TRUE(dry.ceilings.empty());
  const DampingData both[] = {in_room, dry};
  const DampingData all = joined(both);
  ASSERT_EQ(all.ceilings.size(), 3u);
  EXPECT_EQ(all.ceilings[2], core::infinity);
}

}  // namespace
}  // namespace carillon::eval::damping
