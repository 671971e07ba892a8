#include "synth/damping/damping.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/damping/damping_text.hpp"

namespace carillon::synth {
namespace {

constexpr double pi = std::numbers::pi;
using Real = long double;

double at_hertz(double f) {
  return std::pow(2 * pi * f, 2);
}

double c_of(const damping::DampingModel& model, double lambda) {
  return damping::damping_function(model)(lambda);
}

std::string message_of(const damping::DampingModel& model) {
  try {
    damping::check_damping(model);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "no error";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

damping::DampingModel expression(const std::string& text, std::vector<double> alphas = {}) {
  return {damping::DampingKind::expression, std::move(alphas), text};
}

/// c as the papers write it, with omega^2 in place of lambda and without Horner's scheme.
Real as_written(const damping::DampingModel& model, Real omega) {
  const auto& a = model.parameters;
  Real c = 0;
  switch (model.kind) {
    case damping::DampingKind::power:
      return a[0] * std::pow(omega, 2 * Real(a[1]));
    case damping::DampingKind::hybrid:
      return a[0] + a[1] * std::pow(omega, 2 * Real(a[2]));
    default:
      for (std::size_t j = 0; j < a.size(); ++j) c += a[j] * std::pow(omega, Real(2 * j));
      return c;
  }
}

/// Any model with parameters of the size that materials have.
damping::DampingModel any_model() {
  const auto unit = [] { return *rc::gen::inRange(1, 1000) * 1e-3; };
  switch (*rc::gen::inRange(0, 4)) {
    case 0:
      return damping::rayleigh_damping(50 * unit(), 1e-6 * unit());
    case 1:
      return {damping::DampingKind::caughey,
              {300 * unit(), -1e-7 * unit(), 1e-14 * unit(), -1e-25 * unit()},
              ""};
    case 2:
      return {damping::DampingKind::power, {5 * unit(), unit() - 0.2}, ""};
    default:
      return {damping::DampingKind::hybrid, {50 * unit(), 1e-6 * unit(), 0.5 + unit()}, ""};
  }
}

TEST(Damping, IsWhatThePapersWrite) {
  EXPECT_TRUE(rc::check("as written", [] {
    const damping::DampingModel model = any_model();
    const double omega = *rc::gen::inRange(1, 150000);
    const double c = c_of(model, omega * omega);
    const Real expected = as_written(model, omega);
    // Terms of a series cancel: rounding is relative to the largest.
    Real scale = std::abs(expected);
    if (model.kind == damping::DampingKind::caughey) {
      for (std::size_t j = 0; j < model.parameters.size(); ++j) {
        scale = std::max(scale, std::abs(model.parameters[j]) * std::pow(Real(omega), Real(2 * j)));
      }
    }
    RC_ASSERT(std::abs(c - expected) <= 1e-14 * scale);
  }));
}

TEST(Damping, IsScaledAtEveryFrequency) {
  EXPECT_TRUE(rc::check("scaled", [] {
    damping::DampingModel model = any_model();
    if (*rc::gen::inRange(0, 4) == 0) model = expression("6 + 1e-7 * lambda - omega / 1e4");
    const double factor = *rc::gen::inRange(1, 2000) * 1e-2;
    const double lambda = std::pow(*rc::gen::inRange(1, 150000), 2);
    const double c = c_of(model, lambda);
    const damping::DampingModel more = damping::scaled(model, factor);
    RC_ASSERT(more.kind == model.kind);
    RC_ASSERT(std::abs(c_of(more, lambda) - factor * c) <= 1e-9 * factor * (1 + std::abs(c)));
  }));
}

// The dissertation and the article: "a 10 kHz mode on the porcelain plate has d = 20 with
// alpha3 = 1.027" (c = 41.2), and 12 with alpha3 = 1.
TEST(Damping, OfThePorcelainPlateIsAsPublished) {
  EXPECT_NEAR(c_of({damping::DampingKind::hybrid, {3.9, 5.2e-9, 1.027}, ""}, at_hertz(1e4)), 41.2,
              0.05);
  EXPECT_NEAR(c_of({damping::DampingKind::hybrid, {3.9, 5.2e-9, 1}, ""}, at_hertz(1e4)) / 2, 12.2,
              0.05);
}

TEST(Damping, ModelsContainEachOther) {
  for (const double f : {20.0, 440.0, 19999.0}) {
    const double lambda = at_hertz(f);
    const double rayleigh = c_of(damping::rayleigh_damping(3, 2e-8), lambda);
    EXPECT_DOUBLE_EQ(c_of({damping::DampingKind::hybrid, {3, 2e-8, 1}, ""}, lambda), rayleigh);
    EXPECT_EQ(c_of({damping::DampingKind::caughey, {3, 2e-8}, ""}, lambda), rayleigh);
    EXPECT_EQ(c_of({damping::DampingKind::caughey, {3, 2e-8, 0, 0}, ""}, lambda), rayleigh);
    EXPECT_EQ(c_of({damping::DampingKind::hybrid, {0, 0.2, 0.3}, ""}, lambda),
              c_of({damping::DampingKind::power, {0.2, 0.3}, ""}, lambda));
    EXPECT_EQ(c_of({damping::DampingKind::caughey, {7}, ""}, lambda), 7);
  }
}

TEST(Damping, ExpressionsSayWhatModelsSay) {
  for (const double f : {0.0, 20.0, 440.0, 19999.0}) {
    const double lambda = at_hertz(f);
    const auto equal = [&](const damping::DampingModel& a, const damping::DampingModel& b) {
      EXPECT_NEAR(c_of(a, lambda), c_of(b, lambda), 1e-13 * c_of(b, lambda)) << f;
    };
    equal(expression("6 + 1e-7*lambda"), damping::rayleigh_damping(6, 1e-7));
    equal(expression("alpha1 + alpha2*omega^2", {6, 1e-7}), damping::rayleigh_damping(6, 1e-7));
    equal(expression("0.02*(2*pi*f)^0.89"), {damping::DampingKind::power, {0.02, 0.445}, ""});
    EXPECT_EQ(c_of(expression("f > 100 ? 3 : 4"), lambda), f > 100 ? 3 : 4);
    EXPECT_EQ(c_of(expression("max(6, min(1, lambda))"), lambda), 6);
  }
}

TEST(Damping, AnExpressionThatCannotBeReadPointsAtThePlace) {
  const auto says = [](const std::string& text, const std::string& part) {
    const std::string message = message_of(expression(text));
    EXPECT_TRUE(contains(message, part)) << message;
    EXPECT_TRUE(contains(message, "hint")) << message;
  };
  says("6 + 1e-7*lamda", "unknown name \"lamda\" at character 10; did you mean \"lambda\"?");
  says("hybird", "did you mean \"hybrid\"?");
  says("6 + * 3", "\"*\" does not fit at character 5");
  says("6 +", "ends too early at character");
  says("(6 + lambda", "a parenthesis is not closed");
  says("", "there is no formula");
  says("   ", "there is no formula");
  says("2 lambda", "\"lambda\" does not fit at character 3");
  says("lambda = 3", "assigns at character 8");
  says("6, 1e-7*lambda", "a comma outside a function at character 2");
  says("alpha1 + lambda", "alpha1 has no value at character 1");
  says("nan", "unknown name \"nan\"");
  EXPECT_EQ(message_of(expression("lambda >= 1e6 ? 3 : 4")), "no error");
  EXPECT_EQ(message_of(expression("lambda == 0 ? 3 : 4")), "no error");
  EXPECT_TRUE(contains(message_of(expression("6", {3})), "alpha1 is given, but does not stand"));
}

TEST(Damping, RulesNameTheParameter) {
  EXPECT_EQ(message_of({}), "no error");
  EXPECT_TRUE(
      contains(message_of(damping::rayleigh_damping(-1, 0)), "alpha1 must not be negative"));
  EXPECT_TRUE(
      contains(message_of(damping::rayleigh_damping(0, -1e-9)), "alpha2 must not be negative"));
  EXPECT_TRUE(contains(message_of({damping::DampingKind::hybrid, {1, -1, 1}, ""}), "alpha2"));
  EXPECT_TRUE(contains(message_of({damping::DampingKind::power, {-1, 1}, ""}), "alpha1"));
  EXPECT_EQ(message_of({damping::DampingKind::power, {1, -1}, ""}), "no error");
  EXPECT_EQ(message_of({damping::DampingKind::caughey, {1, -1, 1}, ""}), "no error");
  EXPECT_TRUE(contains(message_of(damping::rayleigh_damping(NAN, 0)), "alpha1 must be finite"));
  EXPECT_TRUE(
      contains(message_of({damping::DampingKind::caughey, {1, 2, INFINITY}, ""}), "alpha3"));
  EXPECT_TRUE(contains(message_of({damping::DampingKind::hybrid, {1, 2}, ""}),
                       "takes 3 parameters, not 2"));
  EXPECT_TRUE(
      contains(message_of({damping::DampingKind::caughey, {}, ""}), "takes 1 parameter or more"));
}

TEST(Damping, CoefficientsComeInTheOrderOfEigenvalues) {
  const std::vector<double> lambda = {1e4, 1e6, 1e4};
  const auto c = damping::damping_coefficients(damping::rayleigh_damping(1, 1e-4), lambda);
  EXPECT_EQ(c, (std::vector<double>{2, 101, 2}));
  EXPECT_TRUE(damping::damping_coefficients(damping::rayleigh_damping(1, 1), {}).empty());
}

TEST(Damping, KnowsWhatIsUndamped) {
  EXPECT_TRUE(damping::is_undamped({}));
  EXPECT_FALSE(damping::is_undamped(damping::rayleigh_damping(0, 1e-9)));
  EXPECT_TRUE(damping::is_undamped({damping::DampingKind::power, {0, 0.3}, ""}));
  EXPECT_TRUE(damping::is_undamped({damping::DampingKind::hybrid, {0, 0, 1}, ""}));
  EXPECT_FALSE(damping::is_undamped({damping::DampingKind::hybrid, {1, 0, 1}, ""}));
  EXPECT_TRUE(damping::is_undamped({damping::DampingKind::caughey, {0, 0, 0}, ""}));
  EXPECT_FALSE(damping::is_undamped(expression("0")));
}

TEST(Damping, FormulasCarryTheirNumbersAndUnits) {
  EXPECT_EQ(damping::formula_of(damping::rayleigh_damping(6, 1e-7)), "c = 6 + 1e-07 lambda");
  EXPECT_EQ(damping::formula_of({damping::DampingKind::caughey, {420, -2.4e-6, 3.8e-15}, ""}),
            "c = 420 - 2.4e-06 lambda + 3.8e-15 lambda^2");
  EXPECT_EQ(damping::formula_of({damping::DampingKind::power, {163, 0.01}, ""}),
            "c = 163 lambda^0.01");
  EXPECT_EQ(damping::formula_of(expression("alpha1*f", {3})), "c = alpha1*f, alpha1 = 3");
  EXPECT_EQ(damping::parameter_unit(damping::DampingKind::caughey, 3), "s^5");
  EXPECT_EQ(damping::parameter_unit(damping::DampingKind::rayleigh, 0), "1/s");
  EXPECT_EQ(damping::parameter_unit(damping::DampingKind::hybrid, 2), "1");
}

// c = a (lambda - l1)(lambda - l2): negative exactly between the roots.
TEST(NegativeRanges, OfASeriesAreBetweenItsRoots) {
  const double l1 = at_hertz(812.5), l2 = at_hertz(3456.7);
  const damping::DampingModel model{
      damping::DampingKind::caughey, {1e-15 * l1 * l2, -1e-15 * (l1 + l2), 1e-15}, ""};
  const auto ranges = damping::negative_ranges(model, 20, 20000);
  ASSERT_EQ(ranges.size(), 1u);
  EXPECT_NEAR(ranges[0].low, 812.5, 1e-5);
  EXPECT_NEAR(ranges[0].high, 3456.7, 1e-4);
  // Cut by the band on either side.
  EXPECT_EQ(damping::negative_ranges(model, 1000, 2000).at(0).low, 1000);
  EXPECT_EQ(damping::negative_ranges(model, 1000, 2000).at(0).high, 2000);
  EXPECT_TRUE(damping::negative_ranges(model, 3500, 20000).empty());
  EXPECT_TRUE(damping::negative_ranges(damping::rayleigh_damping(0, 0), 20, 20000).empty());
  EXPECT_EQ(damping::negative_ranges(expression("cos(2*pi*f/1000)"), 20, 3000).size(), 3u);
  EXPECT_THROW(damping::negative_ranges(model, 0, 1), core::InputError);
  EXPECT_THROW(damping::negative_ranges(model, 2, 1), core::InputError);
}

solvers::modes::Modes modes_of(const std::vector<double>& hertz, int regions) {
  solvers::modes::Modes modes;
  for (const double f : hertz) modes.eigenvalues.push_back(at_hertz(f));
  const auto n = static_cast<Eigen::Index>(hertz.size());
  modes.kinetic_fraction = Eigen::MatrixXd::Constant(n, regions, 1.0 / regions);
  modes.strain_fraction = modes.kinetic_fraction;
  return modes;
}

TEST(DecayRates, OfOneRegionAreHalfTheModel) {
  EXPECT_TRUE(rc::check("one region", [] {
    const std::vector<damping::DampingModel> model = {any_model()};
    solvers::modes::Modes modes = modes_of({20, 99, 1000, 19000}, 1);
    // Shares that rounding took off one must not show.
    modes.kinetic_fraction *= 1 - 1e-15;
    const damping::DecayRates rates = damping::clamped_decay_rates(modes, model);
    for (std::size_t i = 0; i < modes.size(); ++i) {
      RC_ASSERT(rates.values[i] == std::max(0.0, c_of(model[0], modes.eigenvalues[i]) / 2));
    }
  }));
}

TEST(DecayRates, OfRegionsOfOneModelAreThatModels) {
  EXPECT_TRUE(rc::check("same model", [] {
    const damping::DampingModel model = any_model();
    solvers::modes::Modes modes = modes_of({20, 99, 1000, 19000}, 2);
    modes.kinetic_fraction << 0.1, 0.9, 0.5, 0.5, 0.3, 0.7, 1, 0;
    modes.strain_fraction << 0.8, 0.2, 0.4, 0.6, 0, 1, 0.25, 0.75;
    const damping::DecayRates two = damping::clamped_decay_rates(modes, std::vector{model, model});
    for (std::size_t i = 0; i < modes.size(); ++i) {
      const double d = c_of(model, modes.eigenvalues[i]) / 2;
      if (!std::isfinite(c_of(model, 0))) return;  // weighed otherwise, below
      RC_ASSERT(std::abs(two.values[i] - std::max(0.0, d)) <= 1e-12 * std::abs(d) + 1e-12);
    }
  }));
}

TEST(DecayRates, OfRegionsWeighWhatIsLeftAtRestByKineticEnergy) {
  solvers::modes::Modes modes = modes_of({1000}, 3);
  modes.kinetic_fraction << 0.2, 0.3, 0.5;
  modes.strain_fraction << 0.6, 0.1, 0.3;
  const double lambda = modes.eigenvalues[0];
  const std::vector<damping::DampingModel> regions = {
      {damping::DampingKind::hybrid, {4, 2e-6, 0.9}, ""},
      {damping::DampingKind::power, {3e3, -0.25}, ""},  // not finite at rest
      expression("5 + f")};
  const double expected = 4 * 0.2 + 2e-6 * std::pow(lambda, 0.9) * 0.6 +
                          3e3 * std::pow(lambda, -0.25) * (0.3 + 0.1) / 2 + 5 * 0.5 + 1000 * 0.3;
  EXPECT_NEAR(damping::decay_rates(modes, regions)[0], expected / 2, 1e-10);
}

TEST(DecayRates, NegativeDampingNamesTheFrequencies) {
  const double l1 = at_hertz(800), l2 = at_hertz(3000);
  const std::vector<damping::DampingModel> model = {
      {damping::DampingKind::caughey, {1e-15 * l1 * l2, -1e-15 * (l1 + l2), 1e-15}, ""}};
  const solvers::modes::Modes modes = modes_of({500, 900, 2500, 3100}, 1);
  const damping::DecayRates rates = damping::clamped_decay_rates(modes, model);
  EXPECT_EQ(rates.negative, (std::vector<std::size_t>{1, 2}));
  EXPECT_EQ(rates.values[1], 0);
  EXPECT_GT(rates.values[3], 0);
  try {
    damping::decay_rates(modes, model);
    FAIL() << "no error";
  } catch (const core::InputError& error) {
    const std::string text = error.what();
    EXPECT_TRUE(contains(text, "2 of 4 modes is negative, from 900 to 2500 Hz")) << text;
    EXPECT_TRUE(contains(text, "below zero from 800 to 3000 Hz")) << text;
    EXPECT_TRUE(contains(text, "clamp")) << text;
  }
}

TEST(DecayRates, WhatIsNotFiniteNamesTheFrequency) {
  const solvers::modes::Modes modes = modes_of({500, 900}, 1);
  for (const char* text : {"1/(f > 600 ? 0 : 1)", "f > 600 ? sqrt(-1) : 1"}) {
    try {
      damping::decay_rates(modes, std::vector{expression(text)});
      FAIL() << "no error: " << text;
    } catch (const core::InputError& error) {
      EXPECT_TRUE(contains(error.what(), "900 Hz is not finite")) << error.what();
    }
  }
}

TEST(MakeDamping, ReadsNamesAndFormulas) {
  EXPECT_EQ(damping::make_damping("", {}), damping::DampingModel{});
  EXPECT_EQ(damping::make_damping("", {{2, 1e-7}}), damping::rayleigh_damping(0, 1e-7));
  EXPECT_EQ(damping::make_damping("rayleigh", {{1, 3}}), damping::rayleigh_damping(3, 0));
  EXPECT_EQ(damping::make_damping("caughey", {{1, 1}, {2, 2}, {3, 3}, {4, 4}}).parameters.size(),
            4u);
  EXPECT_EQ(damping::make_damping("hybrid", {{1, 1}, {2, 2}, {3, 3}}).kind,
            damping::DampingKind::hybrid);
  EXPECT_EQ(damping::make_damping("6", {}), expression("6"));
  EXPECT_EQ(damping::make_damping("alpha1*f", {{1, 3}}), expression("alpha1*f", {3}));
  EXPECT_THROW(damping::make_damping("", {{3, 1}}), core::InputError);
  EXPECT_THROW(damping::make_damping("power", {{1, 1}}), core::InputError);
  EXPECT_THROW(damping::make_damping("caughey", {}), core::InputError);
  EXPECT_THROW(damping::make_damping("caughey", {{1, 1}, {3, 1}}), core::InputError);
  EXPECT_THROW(damping::make_damping("hybrid", {{1, 1}, {2, 1}, {3, 1}, {4, 1}}), core::InputError);
  EXPECT_EQ(damping::alpha_number("alpha12"), 12);
  for (const char* word : {"alpha", "alpha0", "alpha01", "alphab", "beta1", "alpha1x"}) {
    EXPECT_FALSE(damping::alpha_number(word).has_value()) << word;
  }
}

}  // namespace
}  // namespace carillon::synth
