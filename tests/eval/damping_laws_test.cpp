// Every law by every estimator: data on a curve give the curve back, names of the same law agree.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "eval/damping/fit_damping.hpp"
#include "eval/damping/law_text.hpp"
#include "tests/eval/drawn_features.hpp"

namespace carillon::eval {
namespace {

using synth::damping::DampingKind;
using synth::damping::DampingModel;
constexpr damping::Estimator estimators[] = {damping::Estimator::mixture, damping::Estimator::emg,
                                             damping::Estimator::least_squares,
                                             damping::Estimator::lower_bound};

/// Points on a curve, from 200 Hz to 12 kHz.
damping::DampingData on_curve(const DampingModel& model, std::size_t points = 40) {
  damping::DampingData data;
  for (std::size_t i = 0; i < points; ++i) {
    const double f = 200 * std::pow(60, static_cast<double>(i) / static_cast<double>(points - 1));
    data.eigenvalues.push_back(std::pow(2 * std::numbers::pi * f, 2));
  }
  data.coefficients = synth::damping::damping_coefficients(model, data.eigenvalues);
  return data;
}

/// Largest relative difference of two curves at the data's frequencies.
double difference(const DampingModel& a, const DampingModel& b, const damping::DampingData& data) {
  const auto ca = synth::damping::damping_coefficients(a, data.eigenvalues);
  const auto cb = synth::damping::damping_coefficients(b, data.eigenvalues);
  double maximum = 0;
  for (std::size_t i = 0; i < ca.size(); ++i) {
    maximum = std::max(maximum, std::abs(ca[i] - cb[i]) / std::abs(cb[i]));
  }
  return maximum;
}

struct Case {
  const char* word;
  DampingModel model;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = {
      {"rayleigh", synth::damping::rayleigh_damping(6, 1e-7)},
      {"rayleigh", synth::damping::rayleigh_damping(0, 1e-7)},
      {"rayleigh", synth::damping::rayleigh_damping(6, 0)},
      {"caughey:1", {DampingKind::caughey, {7}, ""}},
      {"caughey", {DampingKind::caughey, {420, -2.4e-7, 3.8e-17}, ""}},
      {"caughey:5", {DampingKind::caughey, {9, 1e-8, -1e-19, 2e-28, 1e-38}, ""}},
      {"power", {DampingKind::power, {0.02, 0.445}, ""}},
      {"power", {DampingKind::power, {163, 0.01}, ""}},
      {"power", {DampingKind::power, {4e5, -0.5}, ""}},
      {"hybrid", {DampingKind::hybrid, {3.9, 5.2e-9, 1.027}, ""}},
      {"hybrid", {DampingKind::hybrid, {34.83, 4.1e-7, 0.95}, ""}},
      {"alpha1 + alpha2*sqrt(f)", {DampingKind::expression, {4, 0.3}, "alpha1 + alpha2*sqrt(f)"}},
      {"3 + alpha1*lambda", {DampingKind::expression, {1e-8}, "3 + alpha1*lambda"}},
      {"alpha1*(1 + (f/alpha2)^2)",
       {DampingKind::expression, {5, 3000}, "alpha1*(1 + (f/alpha2)^2)"}},
      {"alpha1 + alpha2*f^alpha3",
       {DampingKind::expression, {5, 2e-5, 1.5}, "alpha1 + alpha2*f^alpha3"}}};
  return all;
}

TEST(DampingLaws, PointsOnACurveGiveItBack) {
  for (const Case& c : cases()) {
    const damping::DampingData data = on_curve(c.model);
    const damping::DampingLaw law = damping::damping_law(c.word);
    for (const damping::Estimator estimator : estimators) {
      const damping::DampingFit fit = damping::fit_damping(data, law, {estimator, false, false});
      EXPECT_TRUE(fit.converged) << c.word << ", " << damping::name_of(estimator);
      // A mixture has errors of a thousandth of c at least.
      const double tolerance = estimator == damping::Estimator::mixture ? 1e-3 : 1e-6;
      EXPECT_LT(difference(fit.model, c.model, data), tolerance)
          << c.word << ", " << damping::name_of(estimator) << ": "
          << synth::damping::formula_of(fit.model);
      EXPECT_EQ(fit.points, 40u);
    }
  }
}

// Formulas of the models that have names give what the names give, on scattered points.
TEST(DampingLaws, FormulasAgreeWithNames) {
  const damping::DampingData data = drawn_features({120, 1, 10}, 3);
  const std::pair<const char*, const char*> pairs[] = {
      {"rayleigh", "alpha1 + alpha2*lambda"},
      {"caughey:3", "alpha1 + alpha2*lambda + alpha3*lambda^2"},
      {"power", "alpha1*lambda^alpha2"},
      {"hybrid", "alpha1 + alpha2*lambda^alpha3"}};
  for (const auto& [name, formula] : pairs) {
    for (const damping::Estimator estimator : estimators) {
      const damping::DampingFit named =
          damping::fit_damping(data, damping::damping_law(name), {estimator, false, false});
      const damping::DampingFit written =
          damping::fit_damping(data, damping::damping_law(formula), {estimator, false, false});
      EXPECT_NEAR(written.log_likelihood, named.log_likelihood, 1e-4)
          << formula << ", " << damping::name_of(estimator);
      EXPECT_LT(difference(written.model, named.model, data), 2e-3)
          << formula << ", " << damping::name_of(estimator) << ": "
          << synth::damping::formula_of(named.model) << " and "
          << synth::damping::formula_of(written.model);
    }
  }
}

// Other units of time: frequencies k times as high, damping m times.
TEST(DampingLaws, FollowTheUnits) {
  EXPECT_TRUE(rc::check("units", [] {
    const damping::DampingData data = drawn_features({40, 1, 10}, *rc::gen::inRange(0, 1000));
    const double k = std::pow(10, *rc::gen::inRange(-6, 6));
    const double m = std::pow(10, *rc::gen::inRange(-6, 6));
    damping::DampingData other = data;
    for (double& lambda : other.eigenvalues) lambda *= k * k;
    for (double& c : other.coefficients) c *= m;
    for (const damping::Estimator estimator : estimators) {
      const auto a = damping::fit_damping(data, {}, {estimator, true, false});
      const auto b = damping::fit_damping(other, {}, {estimator, true, false});
      const auto near = [](double x, double y, double tolerance = 1e-5) {
        RC_ASSERT(x == y || std::abs(x - y) <= tolerance * (std::abs(x) + std::abs(y)));
      };
      // A parameter that makes less than 1e-9 of the damping is none, however it is rounded.
      const double c = *std::max_element(other.coefficients.begin(), other.coefficients.end());
      const double lambda = *std::max_element(other.eigenvalues.begin(), other.eigenvalues.end());
      const auto part = [](double x, double size) { return std::abs(x) < 1e-9 * size ? 0 : x; };
      near(part(b.model.parameters[0], c), part(m * a.model.parameters[0], c));
      near(part(b.model.parameters[1], c / lambda),
           part(m / k / k * a.model.parameters[1], c / lambda));
      near(b.sigma, damping::is_in_proportion(estimator) ? a.sigma : m * a.sigma);
      near(b.eta, a.eta / m);
      // The ends of a profile are found to 1e-3 of their drop, by way of where rounding leads.
      const double end = estimator == damping::Estimator::mixture ? 1e-3 : 1e-5;
      near(b.confidence95[0].high, m * a.confidence95[0].high, end);
    }
  }));
}

TEST(DampingLaws, AreReadFromWords) {
  EXPECT_EQ(damping::damping_law("caughey:5").parameters, 5u);
  EXPECT_EQ(damping::damping_law("caughey").parameters, 3u);
  EXPECT_EQ(damping::damping_law("alpha1 + max(alpha2, f)").parameters, 2u);
  EXPECT_EQ(damping::formula_of(damping::damping_law("caughey:3")),
            "c = alpha1 + alpha2 lambda + alpha3 lambda^2");
  const auto says = [](const char* word, const char* part) {
    try {
      damping::damping_law(word);
      ADD_FAILURE() << word;
    } catch (const core::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  says("caughey:0", "no Caughey series");
  says("caughey:x", "no Caughey series");
  says("6 + 1e-7*lambda", "has no number that could be fitted");
  says("alpha1 + alpha3*f", "has alpha3, but no alpha2");
  says("hybird", "did you mean \"hybrid\"");
  says("alpha1 + lamda", "did you mean \"lambda\"");
}

}  // namespace
}  // namespace carillon::eval
