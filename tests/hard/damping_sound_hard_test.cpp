// Damping that breaks synthesizers: none, critical, beyond, negative, and formulas without a value.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::synth {
namespace {

using Real = long double;
using Complex = std::complex<Real>;
constexpr double pi = std::numbers::pi;
constexpr double audio_rate = 44100;

double at_hertz(double f) {
  return std::pow(2 * pi * f, 2);
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

solvers::modes::Modes modes_at(const std::vector<double>& hertz) {
  solvers::modes::Modes modes;
  for (const double f : hertz) modes.eigenvalues.push_back(at_hertz(f));
  modes.kinetic_fraction = Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(hertz.size()), 1);
  modes.strain_fraction = modes.kinetic_fraction;
  return modes;
}

/// Velocity after unit impulses on every mode, all heard alike.
modal::RingDown struck(const solvers::modes::Modes& modes, const std::vector<double>& d) {
  modal::RingDown rings;
  const auto n = static_cast<Eigen::Index>(modes.size());
  rings.eigenvalues = modes.eigenvalues;
  rings.decay_rates = d;
  rings.excitation = Eigen::VectorXd::Ones(n);
  rings.readout.velocity = Eigen::MatrixXd::Ones(1, n);
  rings.readout.delays = {0};
  return rings;
}

std::vector<float> sound_of(const solvers::modes::Modes& modes, const std::vector<double>& d,
                            std::size_t count = 2000) {
  return modal::synthesize(struck(modes, d), {0}, audio_rate, count);
}

/// q' of q'' + 2 d q' + lambda q = delta(t), from the poles; any damping but the critical one.
Real velocity(Real lambda, Real d, Real t) {
  const Complex root = std::sqrt(Complex(d * d - lambda));
  const Complex s1 = -d + root, s2 = -d - root;
  return ((s1 * std::exp(s1 * t) - s2 * std::exp(s2 * t)) / (s1 - s2)).real();
}

double worst_against_poles(const solvers::modes::Modes& modes, const std::vector<double>& d) {
  const auto sound = sound_of(modes, d);
  double worst = 0;
  for (std::size_t n = 0; n < sound.size(); ++n) {
    Real expected = 0;
    for (std::size_t i = 0; i < d.size(); ++i) {
      expected += velocity(modes.eigenvalues[i], d[i], Real(n) / audio_rate);
    }
    worst = std::max(worst, std::abs(double(expected) - sound[n]));
  }
  return worst;
}

damping::DampingModel formula(const std::string& text) {
  return {damping::DampingKind::expression, {}, text};
}

std::string error_of(const damping::DampingModel& model, const solvers::modes::Modes& modes) {
  try {
    damping::decay_rates(modes, std::span(&model, 1));
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(DampingHard, NoDampingRingsForEver) {
  const solvers::modes::Modes modes = modes_at({440});
  const damping::DampingModel none;
  const auto d = damping::decay_rates(modes, std::span(&none, 1));
  EXPECT_EQ(d[0], 0);
  EXPECT_TRUE(std::isinf(modal::t60(d[0])));
  const auto sound = sound_of(modes, d, 44100 * 20);
  for (std::size_t n = sound.size() - 1000; n < sound.size(); ++n) {
    const Real t = Real(n) / audio_rate;
    ASSERT_NEAR(sound[n], std::cos(std::sqrt(Real(modes.eigenvalues[0])) * t), 1e-6);
  }
}

// The series of these two objects are over-critical from 5.2 and 2.4 kHz on.
TEST(DampingHard, PublishedOverCriticalSets) {
  const solvers::modes::Modes modes =
      modes_at({300, 2000, 2424, 2425, 4000, 5219, 5220, 9000, 20000});
  for (const char* name : {"gpd_plastic_2_caughey", "gpd_aluminum_caughey"}) {
    const damping::DampingModel model = material::parse_material(name).damping;
    const auto d = damping::decay_rates(modes, std::span(&model, 1));
    EXPECT_GT(d.back(), 2 * pi * 20000) << name;
    EXPECT_LT(worst_against_poles(modes, d), 3e-6) << name;
  }
}

// Through the critical point the sound changes as little as the damping does.
TEST(DampingHard, ContinuousThroughCritical) {
  for (const char* name : {"gpd_plastic_2_caughey", "gpd_aluminum_caughey"}) {
    const auto c = damping::damping_function(material::parse_material(name).damping);
    double low = 1000, high = 9000;  // d < omega at one end, d > omega at the other
    while (high - low > 1e-9 * low) {
      const double middle = (low + high) / 2;
      (c(at_hertz(middle)) / 2 < 2 * pi * middle ? low : high) = middle;
    }
    const auto at = [&](double f) { return sound_of(modes_at({f}), {c(at_hertz(f)) / 2}, 200); };
    const auto critical = at(low);
    const double omega = 2 * pi * low;
    for (std::size_t n = 0; n < critical.size(); ++n) {
      const double t = double(n) / audio_rate;
      ASSERT_NEAR(critical[n], (1 - omega * t) * std::exp(-omega * t), 1e-6) << name;
    }
    for (const double step : {1e-3, 1e-5, 1e-7}) {
      const auto below = at(low * (1 - step)), above = at(low * (1 + step));
      for (std::size_t n = 0; n < critical.size(); ++n) {
        ASSERT_NEAR(below[n], critical[n], 4 * step + 1e-6) << name << " " << step;
        ASSERT_NEAR(above[n], critical[n], 4 * step + 1e-6) << name << " " << step;
      }
    }
  }
}

TEST(DampingHard, FarBeyondCriticalCreepsBack) {
  const solvers::modes::Modes modes = modes_at({100});
  for (const double d : {1e4, 1e6, 1e9, 1e15}) {
    const auto sound = sound_of(modes, {d}, 500);
    for (const float sample : sound) ASSERT_TRUE(std::isfinite(sample));
    EXPECT_LT(worst_against_poles(modes, {d}), 1e-6) << d;
  }
}

struct Growing {
  solvers::modes::Modes modes = modes_at({500, 900, 2500, 3100});
  damping::DampingModel model;
  Growing() {
    const double l1 = at_hertz(800), l2 = at_hertz(3000);
    model = {damping::DampingKind::caughey, {1e-15 * l1 * l2, -1e-15 * (l1 + l2), 1e-15}, ""};
  }
};

TEST(DampingHard, NegativeInTheBandAsAnError) {
  const Growing g;
  const std::string error = error_of(g.model, g.modes);
  EXPECT_TRUE(contains(error, "2 of 4 modes")) << error;
  EXPECT_TRUE(contains(error, "from 900 to 2500 Hz")) << error;
  EXPECT_TRUE(contains(error, "below zero from 800 to 3000 Hz")) << error;
  EXPECT_TRUE(contains(error, "clamp") && contains(error, "drop")) << error;
}

TEST(DampingHard, NegativeInTheBandClamped) {
  const Growing g;
  const damping::DecayRates rates = damping::clamped_decay_rates(g.modes, std::span(&g.model, 1));
  const auto sound = sound_of(g.modes, rates.values, 44100);
  // The two that would grow ring on: their sum bounds what is left at the end.
  double end = 0;
  for (std::size_t n = 43000; n < 44100; ++n) end = std::max(end, std::abs(double(sound[n])));
  EXPECT_LE(end, 2 + 2 * std::exp(-rates.values[0]) + 1e-6);
  EXPECT_GT(end, 1.5);
}

TEST(DampingHard, NegativeInTheBandDropped) {
  const Growing g;
  const damping::DecayRates rates = damping::clamped_decay_rates(g.modes, std::span(&g.model, 1));
  modal::RingDown rings = struck(g.modes, rates.values);
  modal::leave_out(rings, rates.negative);
  const auto dropped = modal::synthesize(rings, {0}, audio_rate, 2000);
  const auto others = sound_of(modes_at({500, 3100}), {rates.values[0], rates.values[3]});
  EXPECT_EQ(dropped, others);
  EXPECT_THROW(modal::leave_out(rings, std::vector<std::size_t>{4}), core::InputError);
}

TEST(DampingHard, FormulaThatDividesByZero) {
  const std::string error = error_of(formula("3/(lambda - lambda)"), modes_at({440}));
  EXPECT_TRUE(contains(error, "mode at 440 Hz is not finite")) << error;
  EXPECT_TRUE(contains(error, "3/(lambda - lambda)")) << error;
  // Only at rest, where no mode is, it does no harm.
  EXPECT_EQ(error_of(formula("3/lambda"), modes_at({440})), "no error");
}

TEST(DampingHard, FormulaThatIsNotANumber) {
  const std::string error = error_of(formula("sqrt(-lambda)"), modes_at({440, 880}));
  EXPECT_TRUE(contains(error, "mode at 440 Hz is not finite")) << error;
  EXPECT_TRUE(contains(error_of(formula("f > 600 ? ln(-1) : 1"), modes_at({440, 880})), "880 Hz"));
}

TEST(DampingHard, FormulaThatCannotBeRead) {
  const std::string error = error_of(formula("6 + 1e-7*lamda"), modes_at({440}));
  EXPECT_TRUE(contains(error, "at character 10; did you mean \"lambda\"?")) << error;
  EXPECT_TRUE(contains(error, "hint")) << error;
  EXPECT_TRUE(contains(error_of(formula("6 + (1"), modes_at({440})), "parenthesis"));
}

// A power law that is infinite at rest, in a body of two regions.
TEST(DampingHard, InfiniteAtRest) {
  solvers::modes::Modes modes = modes_at({20, 2000});
  modes.kinetic_fraction = modes.strain_fraction = Eigen::MatrixXd::Constant(2, 2, 0.5);
  const std::vector<damping::DampingModel> regions = {
      {damping::DampingKind::power, {1e3, -0.5}, ""}, formula("20 - ln(lambda)/10")};
  for (const double d : damping::decay_rates(modes, regions)) {
    EXPECT_TRUE(std::isfinite(d));
    EXPECT_GT(d, 0);
  }
}

TEST(DampingHard, OverflowingSeries) {
  std::vector<double> alphas(41, 0.0);
  alphas.back() = 1;  // lambda^40
  const std::string error =
      error_of({damping::DampingKind::caughey, alphas, ""}, modes_at({440, 2e4}));
  EXPECT_TRUE(contains(error, "mode at 20000 Hz is not finite")) << error;
}

}  // namespace
}  // namespace carillon::synth
