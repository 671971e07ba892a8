#include "synth/modal/modal_response.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>
#include <vector>

#include "synth/modal/resonators.hpp"
#include "tests/synth/partial_sum.hpp"
#include "tests/synth/random_rings.hpp"

namespace carillon::synth {
namespace {

using Real = long double;
using Cplx = std::complex<long double>;
constexpr Real pi = std::numbers::pi_v<long double>;
constexpr modal::Weights velocity{0, 1, 0};
constexpr modal::Weights acceleration_weights{0, 0, 1};

/// Motion by classical Runge-Kutta steps of q'' + 2 d q' + lambda q = F(t). Steps end where the
/// force does, whose second derivative jumps there.
modal::ModalMotion step_through(double lambda, double d, double contact_time, double t) {
  const auto force = [&](Real s) {
    return s >= contact_time ? Real(0) : (1 - std::cos(2 * pi * s / contact_time)) / contact_time;
  };
  const auto acceleration = [&](Real s, Real x, Real u) {
    return force(s) - 2 * d * u - lambda * x;
  };
  Real q = 0, v = 0;
  const auto advance = [&](Real begin, Real end) {
    const Real rate = std::sqrt(Real(lambda)) + 2 * d + 1 / Real(contact_time);
    const int steps = std::max(1, static_cast<int>(400 * rate * (end - begin)));
    const Real h = (end - begin) / steps;
    for (int i = 0; i < steps; ++i) {
      const Real s = begin + i * h;
      const Real k1 = v, l1 = acceleration(s, q, v);
      const Real k2 = v + h / 2 * l1, l2 = acceleration(s + h / 2, q + h / 2 * k1, k2);
      const Real k3 = v + h / 2 * l2, l3 = acceleration(s + h / 2, q + h / 2 * k2, k3);
      const Real k4 = v + h * l3, l4 = acceleration(s + h, q + h * k3, k4);
      q += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      v += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    }
  };
  advance(0, std::min(t, contact_time));
  if (t > contact_time) advance(contact_time, t);
  return {double(q), double(v), double(acceleration(t, q, v))};
}

modal::ModalMotion motion_at(const modal::ModalResponse& response, double contact_time, double t) {
  return t < contact_time ? response.during_contact(t) : response.after_contact(t - contact_time);
}

struct StepCase {
  double frequency;     // Hz
  double decay_rate;    // 1/s
  double contact_time;  // s
};

class AgainstRungeKutta : public ::testing::TestWithParam<StepCase> {};

TEST_P(AgainstRungeKutta, ContactAndDecay) {
  const StepCase c = GetParam();
  const double lambda = std::pow(2 * std::numbers::pi * c.frequency, 2);
  const modal::ModalResponse response(lambda, c.decay_rate, c.contact_time);
  double scale_v = 0, scale_a = 0;
  std::vector<std::pair<modal::ModalMotion, modal::ModalMotion>> pairs;
  for (const double fraction : {0.1, 0.35, 0.5, 0.8, 1.0, 1.3, 2.5}) {
    const double t = fraction * c.contact_time;
    const modal::ModalMotion expected = step_through(lambda, c.decay_rate, c.contact_time, t);
    pairs.emplace_back(expected, motion_at(response, c.contact_time, t));
    scale_v = std::max(scale_v, std::abs(expected.velocity));
    scale_a = std::max(scale_a, std::abs(expected.acceleration));
  }
  for (const auto& [expected, found] : pairs) {
    EXPECT_NEAR(found.velocity, expected.velocity, 1e-9 * scale_v);
    EXPECT_NEAR(found.acceleration, expected.acceleration, 1e-9 * scale_a);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Modes, AgainstRungeKutta,
    ::testing::Values(StepCase{440, 5, 1e-3}, StepCase{5000, 80, 2e-4}, StepCase{20, 0.3, 1e-4},
                      // Resonance with the pulse: f = 1 / T, damped and undamped.
                      StepCase{1000, 0, 1e-3}, StepCase{1000, 1e-9, 1e-3},
                      StepCase{1000.0001, 2, 1e-3},
                      // Below, at and above critical damping; far above.
                      StepCase{100, 2 * std::numbers::pi * 99.9999, 1e-3},
                      StepCase{100, 2 * std::numbers::pi * 100, 1e-3},
                      StepCase{100, 2 * std::numbers::pi * 100.0001, 1e-3},
                      StepCase{100, 2 * std::numbers::pi * 101, 5e-3},
                      StepCase{100, 2 * std::numbers::pi * 110, 5e-3}, StepCase{100, 5000, 1e-3},
                      // A long soft contact on a stiff mode: nearly static.
                      StepCase{8000, 40, 5e-3},
                      // A rigid body.
                      StepCase{0, 0, 1e-3}, StepCase{0, 30, 1e-3}));

// The bound that ends near-critical modes is one.
TEST(ModalResponse, BoundHolds) {
  EXPECT_TRUE(rc::check("bound_after_contact", [] {
    const double omega = std::exp(*rc::gen::inRange(0, 1000) * 0.011);
    const double ratio = 0.9951 + 1e-5 * *rc::gen::inRange(0, 900);
    const double contact_time = *rc::gen::element(0.0, 1e-4, 1e-2);
    const modal::ModalResponse response(omega * omega, ratio * omega, contact_time);
    RC_ASSERT(response.near_critical());
    const double begin = *rc::gen::inRange(0, 100) * 0.05 / omega;
    for (int i = 0; i < 200; ++i) {
      const modal::ModalMotion motion = response.after_contact(begin + i * 0.05 / omega);
      RC_ASSERT(std::abs(motion.velocity) <=
                response.bound_after_contact(begin, velocity) * (1 + 1e-9));
      RC_ASSERT(std::abs(motion.acceleration) <=
                response.bound_after_contact(begin, acceleration_weights) * (1 + 1e-9));
    }
  }));
}

// Energy: with an undamped mode and any contact, velocity and displacement after the strike stay on
// one ellipse, whose size is the pulse's spectrum at omega.
TEST(ModalResponse, KeepsEnergyWithoutDamping) {
  EXPECT_TRUE(rc::check("energy", [] {
    const double omega = std::exp(4 + *rc::gen::inRange(0, 700) * 0.01);
    const double contact_time = std::exp(-10 + *rc::gen::inRange(0, 600) * 0.01);
    const modal::ModalResponse response(omega * omega, 0, contact_time);
    // |spectrum| of the unit raised cosine: sinc(x) / (1 - x^2), x = omega T / 2 pi.
    const double x = omega * contact_time / (2 * std::numbers::pi);
    const double y = std::numbers::pi * x;
    const double spectrum = std::abs(x - 1) < 1e-9 ? 0.5 : std::abs(std::sin(y) / y / (1 - x * x));
    for (const double tau : {0.0, 1e-4, 0.3}) {
      const modal::ModalMotion motion = response.after_contact(tau);
      RC_ASSERT(std::abs(std::hypot(motion.velocity, omega * motion.displacement) - spectrum) <
                1e-11 * (1 + omega * tau));
    }
  }));
}

// In double precision: the contact as partials is the closed form wherever it is offered, and what
// its parts lose to cancellation is bounded.
TEST(ModalResponse, ContactAsPartialsIsTheClosedForm) {
  int offered = 0;
  for (const double angle : {0.0101, 0.3, 3.0, 6.2731, 6.2933, 40.0, 3000.0}) {
    for (const double ratio : {0.0, 1e-4, 0.2, 0.9, 1.2, 40.0}) {
      constexpr double contact = 2e-3;
      const double omega = angle / contact;
      const modal::ModalResponse response(omega * omega, ratio * omega, contact);
      if (!response.contact_splits()) continue;
      ++offered;
      for (const modal::Weights& weights :
           {modal::Weights{omega, 0, 0}, velocity, modal::Weights{0, 0, 1 / omega}}) {
        double peak = 0, worst = 0;
        for (int i = 0; i <= 50; ++i) {
          const double t = i * contact / 50;
          const double expected = weights.of(response.during_contact(t));
          Real sum = 0;
          for (const modal::Partial& p : response.contact_partials(weights)) {
            sum +=
                (Cplx(p.amplitude) * std::exp(Cplx(-p.decay_rate, p.angular_frequency) * Real(t)))
                    .real();
          }
          const modal::ForcedMotion forced = response.forced_motion(weights);
          sum += forced.constant +
                 (Cplx(forced.turning) * std::polar(Real(1), 2 * pi * t / contact)).real();
          peak = std::max(peak, std::abs(expected));
          worst = std::max(worst, double(std::abs(sum - expected)));
        }
        peak = std::max(peak, std::abs(weights.of(response.after_contact(1 / omega))));
        // Slow modes: displacement over the contact is far smaller than the parts, but then grows;
        // what counts is the motion to come. Stiff ones: the closed form takes the acceleration
        // as a small difference to the force.
        const double scale = std::max(peak, angle < 1 ? 1.0 : 0.0);
        EXPECT_LT(worst, 1e-11 * scale + 4e-15 * weights.acceleration / contact)
            << angle << " " << ratio << " " << weights.displacement << weights.velocity;
      }
    }
  }
  EXPECT_GT(offered, 25);
}

// In double precision, before rounding to float, with and without ending tails.
TEST(Resonators, AreThePlainSumToTwelveDigits) {
  constexpr int mode_count = 51;
  const modal::RingDown rings = random_rings(mode_count, 7, false);
  std::vector<modal::Partial> partials;
  for (int i = 0; i < mode_count; ++i) {
    const modal::ModalResponse response(rings.eigenvalues[std::size_t(i)],
                                        rings.decay_rates[std::size_t(i)], 1e-3);
    for (modal::Partial partial : response.partials(velocity)) {
      partial.amplitude *= rings.readout.velocity(0, i);
      if (partial.amplitude != 0.0) partials.push_back(partial);
    }
  }
  std::vector<Real> expected(44100, 0);
  double peak = 0;
  for (std::size_t n = 0; n < expected.size(); ++n) {
    for (const modal::Partial& p : partials) {
      expected[n] += (Cplx(p.amplitude) *
                      std::exp(Cplx(-p.decay_rate, p.angular_frequency) * (Real(n) / 44100)))
                         .real();
    }
    peak = std::max(peak, double(std::abs(expected[n])));
  }
  for (const double tail : {0.0, 1e-8}) {
    std::vector<double> sum(44100, 0.0);
    add_partials(partials, 0, 44100, tail, 0, sum);
    double worst = 0;
    for (std::size_t n = 0; n < sum.size(); ++n) {
      worst = std::max(worst, double(std::abs(sum[n] - expected[n])));
    }
    EXPECT_LT(worst, (tail == 0 ? 1e-12 : 1e-8) * peak) << tail;
    if (tail > 0) {
      EXPECT_GT(worst, 1e-13 * peak) << "nothing ended early: the test is idle";
    }
  }
}

/// Makes the vector code choose one instruction set, and all again at the end.
class OneTarget {
 public:
  explicit OneTarget(std::int64_t target) { choose(target); }
  ~OneTarget() { choose(0); }

 private:
  static void choose(std::int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

// Every instruction set this machine has, from two samples a vector to eight.
TEST(Resonators, AgreeOnEveryInstructionSet) {
  const modal::RingDown rings = random_rings(23, 13, false);
  std::vector<modal::Partial> partials;
  for (std::size_t i = 0; i < 23; ++i) {
    const modal::ModalResponse response(rings.eigenvalues[i], rings.decay_rates[i], 0);
    partials.push_back(response.partials(velocity)[0]);
  }
  constexpr std::size_t sample_count = 5003;
  std::vector<double> best(sample_count, 0.0);
  add_partials(partials, 1e-5L, 44100, 0, 0, best);
  int tried = 0;
  const std::int64_t targets = hwy::SupportedTargets() & HWY_TARGETS;
  for (std::int64_t rest = targets; rest != 0; rest &= rest - 1) {
    const OneTarget only(rest & -rest);
    std::vector<double> sum(sample_count, 0.0);
    add_partials(partials, 1e-5L, 44100, 0, 0, sum);
    for (std::size_t n = 0; n < sample_count; ++n) {
      ASSERT_NEAR(sum[n], best[n], 23e-13) << hwy::TargetName(rest & -rest) << " at " << n;
    }
    ++tried;
  }
  EXPECT_GE(tried, 1);
  RecordProperty("instruction_sets", tried);
}

// An undamped mode over a minute: the last second is still in phase to 1e-11 rad.
TEST(Resonators, DoNotDriftInAMinute) {
  const Real omega = 2 * pi * 19876.54321L;
  const modal::Partial partial{{0, -1}, 0, omega};
  std::vector<double> sum(60 * 44100, 0.0);
  add_partials(std::span(&partial, 1), 0, 44100, 1e-8, 0, sum);
  double worst = 0;
  for (std::size_t n = 59 * 44100; n < sum.size(); ++n) {
    worst = std::max(worst, double(std::abs(sum[n] - std::sin(omega * (Real(n) / 44100)))));
  }
  EXPECT_LT(worst, 1e-11);
}

}  // namespace
}  // namespace carillon::synth
