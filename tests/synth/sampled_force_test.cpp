#include "synth/modal/sampled_force.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/error.hpp"
#include "synth/modal/ring_down.hpp"
#include "tests/synth/random_rings.hpp"

namespace carillon::synth {
namespace {

using Real = long double;

struct State {
  Real q = 0, v = 0, a = 0;
};

/// Runge-Kutta steps through a force of straight lines; steps end where it bends.
State step_through(Real lambda, Real d, const modal::ContactForce& force, Real t) {
  const auto pieces = force.samples.size() - 1;
  const Real h = Real(force.duration) / Real(pieces);
  State s;
  Real f = force.samples[0];
  const auto advance = [&](Real length, Real begin, Real end) {
    const int steps = 1 + int(200 * length * (std::sqrt(lambda) + 2 * d));
    const Real dt = length / steps;
    for (int i = 0; i < steps; ++i) {
      const auto at = [&](Real fraction) { return begin + (end - begin) * (i + fraction) / steps; };
      const auto acceleration = [&](Real fraction, Real q, Real v) {
        return at(fraction) - 2 * d * v - lambda * q;
      };
      const Real k1 = s.v, l1 = acceleration(0, s.q, s.v);
      const Real k2 = s.v + dt / 2 * l1, l2 = acceleration(0.5, s.q + dt / 2 * k1, k2);
      const Real k3 = s.v + dt / 2 * l2, l3 = acceleration(0.5, s.q + dt / 2 * k2, k3);
      const Real k4 = s.v + dt * l3, l4 = acceleration(1, s.q + dt * k3, k4);
      s.q += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      s.v += dt / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    }
  };
  for (std::size_t k = 0; k < pieces && Real(k) * h < t; ++k) {
    const Real length = std::min(h, t - Real(k) * h);
    const Real from = force.samples[k];
    f = from + (force.samples[k + 1] - from) * length / h;
    advance(length, from, f);
  }
  if (t >= force.duration) f = 0;
  if (t > force.duration) advance(t - force.duration, 0, 0);
  s.a = f - 2 * d * s.v - lambda * s.q;
  return s;
}

modal::ContactForce burst(double duration, std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  modal::ContactForce force{duration, {}};
  for (std::size_t i = 0; i < count; ++i) force.samples.push_back(normal(random) / duration);
  return force;
}

modal::RingDown one_mode(double lambda, double d, const modal::Weights& weights, double delay) {
  modal::RingDown rings;
  rings.eigenvalues = {lambda};
  rings.decay_rates = {d};
  rings.excitation = Eigen::VectorXd::Ones(1);
  rings.readout.displacement = Eigen::MatrixXd::Constant(1, 1, weights.displacement);
  rings.readout.velocity = Eigen::MatrixXd::Constant(1, 1, weights.velocity);
  rings.readout.acceleration = Eigen::MatrixXd::Constant(1, 1, weights.acceleration);
  rings.readout.delays = {delay};
  return rings;
}

// Steps of the force that go with the samples, that do not, and finer and coarser ones; modes
// below, at and above critical damping, slow, at rest and rigid.
TEST(SampledForce, IsExactForStraightLines) {
  constexpr double audio_rate = 44100;
  constexpr std::size_t sample_count = 40;
  for (const double omega : {0.0, 1e-3, 30.0, 2e3, 2e4, 1.2e5}) {
    for (const double ratio : {0.0, 1e-3, 0.3, 0.9999999, 1.0, 1.0000001, 1.004, 1.1, 30.0}) {
      if (ratio * omega > 3e5) continue;
      const double d = omega > 0 ? ratio * omega : 300 * ratio;
      for (const auto& [duration, points] :
           {std::pair{20 / audio_rate, 21}, {3.3e-4, 2}, {5e-4, 11}, {1e-4, 67}}) {
        const modal::ContactForce force = burst(duration, std::size_t(points), 5);
        for (const double delay : {0.0, 3.3 / audio_rate}) {
          for (const modal::Weights weights :
               {modal::Weights{1, 0, 0}, modal::Weights{0, 1, 0}, modal::Weights{0, 0, 1}}) {
            const auto sound = modal::synthesize(one_mode(omega * omega, d, weights, delay), force,
                                                 audio_rate, sample_count);
            double peak = 0, worst = 0;
            for (std::size_t n = 0; n < sample_count; n += 3) {
              const Real t = Real(n) / audio_rate - delay;
              if (t < 0) continue;
              const State s = step_through(omega * omega, d, force, t);
              const Real expected =
                  weights.displacement * s.q + weights.velocity * s.v + weights.acceleration * s.a;
              peak = std::max(peak, double(std::abs(expected)));
              worst = std::max(worst, double(std::abs(expected - sound[n])));
            }
            // Rounding to float; and Runge-Kutta's own error.
            EXPECT_LT(worst, 1.5e-7 * peak)
                << omega << " " << d << " " << duration << " " << points << " " << delay;
          }
        }
      }
    }
  }
}

// In double precision: one step against two halves, and against many.
TEST(SampledForce, AStepIsTwoHalfSteps) {
  for (const double omega : {0.0, 1e-6, 1.0, 4e4, 4.5e4, 1e6}) {
    for (const double d : {0.0, 1e-9, 1.0, 3.9e4, 4e4, 4.00001e4, 4.1e4, 9e5, 1e9}) {
      for (const double length : {1e-9, 1e-5, 2.4e-5, 2.6e-5, 1e-3}) {
        const modal::LinearForceStep whole = modal::linear_force_step(omega * omega, d, length);
        const modal::LinearForceStep half = modal::linear_force_step(omega * omega, d, length / 2);
        const auto twice = [&](double q, double v, double begin, double end) {
          for (const auto& [from, to] :
               {std::pair{begin, (begin + end) / 2}, {(begin + end) / 2, end}}) {
            const double next = half.qq * q + half.qv * v + half.q_begin * from + half.q_end * to;
            v = half.vq * q + half.vv * v + half.v_begin * from + half.v_end * to;
            q = next;
          }
          return std::pair{q, v};
        };
        const double rate = std::max({omega, 2 * d, 1e-300});
        const auto near = [&](std::pair<double, double> found, double q, double v, double scale) {
          const double reach = std::max(scale * std::min(length, 1 / rate), std::abs(q));
          EXPECT_NEAR(found.first, q, 1e-12 * reach) << omega << " " << d << " " << length;
          EXPECT_NEAR(found.second, v, 1e-12 * scale) << omega << " " << d << " " << length;
        };
        near(twice(0, 1, 0, 0), whole.qv, whole.vv, 1);
        near(twice(0, 0, 1, 0), whole.q_begin, whole.v_begin, std::min(length, 1 / rate));
        near(twice(0, 0, 0, 1), whole.q_end, whole.v_end, std::min(length, 1 / rate));
      }
    }
  }
}

// A raised cosine cut into straight lines tends to the closed form with the square of the step.
TEST(SampledForce, TendsToTheRaisedCosine) {
  const modal::RingDown rings = random_rings(29, 3, false);
  const auto exact = modal::synthesize(rings, {1.3e-3}, 44100, 3000);
  double peak = 0;
  for (const float s : exact) peak = std::max(peak, std::abs(double(s)));
  double last = 0;
  for (const int points : {401, 801, 1601}) {
    modal::ContactForce force{1.3e-3, {}};
    for (int i = 0; i < points; ++i) {
      force.samples.push_back(modal::contact_force(1.3e-3, 1.3e-3 * i / (points - 1)));
    }
    const auto sound = modal::synthesize(rings, force, 44100, 3000);
    double worst = 0;
    for (std::size_t n = 0; n < sound.size(); ++n) {
      worst = std::max(worst, std::abs(double(sound[n]) - double(exact[n])));
    }
    EXPECT_LT(worst, 2e-5 * peak);
    if (last > 0) {
      EXPECT_NEAR(last / worst, 4, 0.8);
    }
    last = worst;
  }
}

TEST(SampledForce, RefusesWhatIsNoForce) {
  const modal::RingDown rings = random_rings(3, 3, false);
  const auto refuses = [&](const modal::ContactForce& force) {
    EXPECT_THROW(modal::synthesize(rings, force, 44100, 10), core::InputError);
  };
  refuses({0, {1, 1}});
  refuses({1e-3, {1}});
  refuses({1e-3, {1, std::nan("")}});
  refuses({1e-3, {std::numeric_limits<double>::infinity(), 0}});
}

TEST(SampledResponse, ComesToTheClosedFormOfAFinelySampledPulse) {
  const double T = 1e-3;
  for (const double d : {0.0, 50.0, 4000.0, 60000.0}) {
    const double lambda = 1e8;
    const modal::ModalResponse exact(lambda, d, T);
    double last = 0;
    for (const int pieces : {100, 200}) {
      std::vector<double> force;
      for (int k = 0; k <= pieces; ++k) force.push_back(modal::contact_force(T, T * k / pieces));
      const modal::SampledResponse response(lambda, d, {T, force});
      double worst = 0, size = 0;
      for (int n = 1; n < 400; ++n) {
        const double t = 2.0 * T * n / 400;
        const modal::ModalMotion a = t <= T ? exact.during_contact(t) : exact.after_contact(t - T);
        const modal::ModalMotion b = response.at(t);
        worst = std::max(worst, std::abs(a.velocity - b.velocity));
        size = std::max(size, std::abs(a.velocity));
      }
      if (pieces == 200) {
        EXPECT_NEAR(last / worst, 4, 0.2) << d;  // of second order
      }
      EXPECT_LT(worst / size, 2e-3) << d;
      last = worst;
    }
    EXPECT_NEAR(modal::SampledResponse(lambda, d, {T, {0, 2 / T, 0}}).impulse(T), 1, 1e-12);
  }
}

TEST(SampledResponse, OfOneRampIsTheTextbooks) {
  // q'' + lambda q = t: q = (t - sin(w t) / w) / lambda, on a grid that does not fall on samples.
  const double w = 300, T = 0.1;
  std::vector<double> force;
  for (int k = 0; k <= 7; ++k) force.push_back(T * k / 7);
  const modal::SampledResponse response(w * w, 0, {T, force});
  for (const double t : {0.001, 0.0437, 0.0999}) {
    EXPECT_NEAR(response.at(t).displacement / ((t - std::sin(w * t) / w) / (w * w)), 1, 1e-9) << t;
    EXPECT_NEAR(response.at(t).acceleration, std::sin(w * t) / w, 1e-9 / w);
    EXPECT_NEAR(response.impulse(t), t * t / 2, 1e-15);
  }
}

// At any time and damping, near the critical one too.
TEST(SampledResponse, IsExactForStraightLines) {
  const modal::ContactForce force = burst(5e-4, 11, 5);
  const Real omega = 2e4L;
  for (const double ratio : {0.0, 0.3, 0.9999999, 1.0, 1.0000001, 1.004, 1.1, 10.0}) {
    const modal::SampledResponse response(double(omega * omega), ratio * double(omega), force);
    double peak = 0, worst = 0;
    for (const double t : {1e-7, 3.3e-5, 5e-5, 2.71e-4, 4.99e-4, 5e-4, 6.1e-4}) {
      const State s = step_through(omega * omega, Real(ratio) * omega, force, t);
      peak = std::max(peak, double(std::abs(s.v)));
      worst = std::max(worst, double(std::abs(s.v - Real(response.at(t).velocity))));
      EXPECT_NEAR(response.at(t).displacement, double(s.q), 1e-9 * peak / double(omega)) << t;
    }
    EXPECT_LT(worst, 1e-9 * peak) << ratio;
  }
}

TEST(SampledResponse, RefusesForcesWithoutExtent) {
  for (const modal::ContactForce& force :
       {modal::ContactForce{1, {}}, {1, {1}}, {0, {1, 2}}, {1, {1, std::nan("")}}}) {
    EXPECT_THROW(modal::SampledResponse(1, 0, force), core::InputError);
  }
}

}  // namespace
}  // namespace carillon::synth
