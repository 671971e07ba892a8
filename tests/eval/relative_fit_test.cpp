#include "eval/material/relative_fit.hpp"

#include <gtest/gtest.h>

#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::eval {
namespace {

using synth::damping::DampingKind;

damping::DampingData data_of(const synth::damping::DampingModel& model, double scatter,
                             std::size_t count, std::uint64_t seed) {
  core::RandomStream random(seed, 0, "test.relative");
  damping::DampingData data;
  for (std::size_t i = 0; i < count; ++i) {
    const double frequency = 500 * std::pow(30, static_cast<double>(i) / (count - 1.0));
    data.eigenvalues.push_back(std::pow(2 * M_PI * frequency, 2));
  }
  data.coefficients = synth::damping::damping_coefficients(model, data.eigenvalues);
  for (double& c : data.coefficients) c *= std::exp(scatter * random.normal());
  return data;
}

TEST(RelativeFit, OfOneParameterIsStudentsInterval) {
  // ln c is Gaussian about ln alpha: mean and interval are in every textbook.
  damping::DampingData data;
  data.eigenvalues = {1e6, 1e7, 1e8, 1e9};
  data.coefficients = {9, 11, 10, 14};
  double mean = 0;
  for (const double c : data.coefficients) mean += std::log(c) / 4;
  double variance = 0;
  for (const double c : data.coefficients) variance += std::pow(std::log(c) - mean, 2) / 3;
  const double t = boost::math::quantile(boost::math::students_t(3), 0.975);
  const double half = t * std::sqrt(variance / 4);
  const auto fit = material::fit_relative(data, {DampingKind::caughey, 1, ""});
  EXPECT_NEAR(std::log(fit.model.parameters[0]), mean, 1e-5);
  EXPECT_NEAR(std::log(fit.confidence95[0].low), mean - half, 1e-3);
  EXPECT_NEAR(std::log(fit.confidence95[0].high), mean + half, 1e-3);
}

TEST(RelativeFit, FindsEveryLaw) {
  const std::vector<std::pair<damping::DampingLaw, std::vector<double>>> laws = {
      {{DampingKind::rayleigh, 2, ""}, {8, 4e-8}},
      {{DampingKind::power, 2, ""}, {0.2, 0.25}},
      {{DampingKind::caughey, 3, ""}, {12, 3e-8, 1e-18}},
      {{DampingKind::expression, 2, "alpha1 + alpha2*f"}, {3, 0.01}},
  };
  for (const auto& [law, alphas] : laws) {
    SCOPED_TRACE(synth::damping::form_of(law.kind).name);
    const synth::damping::DampingModel truth{law.kind, alphas, law.expression};
    const auto data = data_of(truth, 0.05, 8, 3);
    const auto fit = material::fit_relative(data, law);
    const auto found = synth::damping::damping_coefficients(fit.model, data.eigenvalues);
    const auto expected = synth::damping::damping_coefficients(truth, data.eigenvalues);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i] / expected[i], 1, 0.12);
    for (std::size_t k = 0; k < alphas.size(); ++k) {
      EXPECT_LT(fit.confidence95[k].low, fit.model.parameters[k]);
      EXPECT_GT(fit.confidence95[k].high, fit.model.parameters[k]);
    }
  }
}

TEST(RelativeFit, IntervalsOfFewPointsHold) {
  const auto truth = synth::damping::rayleigh_damping(8, 4e-8);
  for (const std::size_t points : {3U, 5U, 9U}) {
    int held[2] = {0, 0};
    constexpr int trials = 100;
    for (std::uint64_t seed = 1; seed <= trials; ++seed) {
      const auto fit = material::fit_relative(data_of(truth, 0.1, points, 10 * seed + points),
                                              {DampingKind::rayleigh, 2, ""});
      for (int k = 0; k < 2; ++k) {
        held[k] += fit.confidence95[k].low <= truth.parameters[k] &&
                   truth.parameters[k] <= fit.confidence95[k].high;
      }
    }
    EXPECT_GE(held[0], 90) << points;
    EXPECT_GE(held[1], 90) << points;
    EXPECT_LT(held[0] + held[1], 2 * trials) << points;
  }
}

TEST(RelativeFit, SaysWhatNothingBounds) {
  // Points high up, where the constant term is a thousandth.
  damping::DampingData data;
  for (const double eigenvalue : {1e9, 2e9, 4e9, 5e9, 8e9}) {
    data.eigenvalues.push_back(eigenvalue);
    data.coefficients.push_back(0.01 + 4e-8 * eigenvalue * (1 + 0.02 * std::sin(eigenvalue)));
  }
  const auto fit = material::fit_relative(data, {DampingKind::rayleigh, 2, ""});
  EXPECT_LT(fit.confidence95[0].low, 1e-3);
  EXPECT_GT(fit.confidence95[0].high, 0.01);
  EXPECT_THROW(material::fit_relative(data_of(synth::damping::rayleigh_damping(8, 4e-8), 0, 2, 1),
                                      {DampingKind::rayleigh, 2, ""}),
               core::InputError);
}

}  // namespace
}  // namespace carillon::eval
