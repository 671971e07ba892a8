#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "synth/modal/streaming_renderer.hpp"
#include "tests/counted_memory.hpp"

namespace carillon::synth {
namespace {

constexpr double change_rate = 44100;
constexpr std::size_t change_samples = 1500;

struct Values {
  std::vector<double> eigenvalues, decay_rates;
};

/// The values from a time on [s].
struct ValuesFrom {
  double time;
  Values values;
};

struct TimedStrike {
  double time;
  double impulse;
  modal::ContactForce force;
};

double square(double x) {
  return x * x;
}

double omega(double frequency) {
  return 2 * std::numbers::pi * frequency;
}

/// Modes that ring, one near and one beyond critical damping.
Values free_values() {
  return {{square(omega(310)), square(omega(1270)), square(omega(820)), square(omega(500))},
          {12, 40, omega(820) * 0.9995, omega(500) * 1.6}};
}

/// Two rows that hear displacement, velocity and acceleration, one of them later.
modal::Readout mixed_readout() {
  modal::Readout readout;
  readout.displacement.resize(2, 4);
  readout.velocity.resize(2, 4);
  readout.acceleration.resize(2, 4);
  for (int r = 0; r < 2; ++r) {
    for (int i = 0; i < 4; ++i) {
      readout.displacement(r, i) = 900 * std::cos(1 + i + 3 * r);
      readout.velocity(r, i) = std::sin(2 + 2 * i + r);
      readout.acceleration(r, i) = 2e-4 * std::cos(5 * i - r);
    }
  }
  readout.delays = {0, 0.0012345};
  return readout;
}

double force_at(const modal::ContactForce& force, double t) {
  if (t < 0 || t > force.duration) return 0;
  if (force.samples.empty()) {
    return (1 - std::cos(2 * std::numbers::pi * t / force.duration)) / force.duration;
  }
  const double place = t / force.duration * double(force.samples.size() - 1);
  const auto i = std::min(std::size_t(place), force.samples.size() - 2);
  return force.samples[i] + (place - double(i)) * (force.samples[i + 1] - force.samples[i]);
}

/// q'' + 2 d(t) q' + lambda(t) q = f(t) of each mode, by the classical Runge-Kutta method in steps
/// of at most 0.6 us that end where the values change, where the force bends and at each sample.
std::vector<double> integrated(const std::vector<ValuesFrom>& course,
                               const std::vector<TimedStrike>& strikes,
                               const Eigen::VectorXd& excitation, const modal::Readout& readout) {
  std::vector<double> out(2 * change_samples, 0.0);
  for (std::size_t r = 0; r < 2; ++r) {
    std::vector<double> stops;
    for (std::size_t n = 0; n < change_samples; ++n) {
      stops.push_back(double(n) / change_rate - readout.delays[r]);
    }
    for (const ValuesFrom& part : course) stops.push_back(part.time);
    for (const TimedStrike& strike : strikes) {
      const std::size_t pieces = std::max<std::size_t>(1, strike.force.samples.size() - 1);
      for (std::size_t k = 0; k <= (strike.force.samples.empty() ? 1 : pieces); ++k) {
        stops.push_back(strike.time + strike.force.duration * double(k) /
                                          double(strike.force.samples.empty() ? 1 : pieces));
      }
    }
    std::sort(stops.begin(), stops.end());
    for (int i = 0; i < 4; ++i) {
      double q = 0, v = 0, t = 0;
      std::size_t n = 0;
      for (const double stop : stops) {
        const auto part = std::find_if(course.rbegin(), course.rend(),
                                       [&](const ValuesFrom& p) { return p.time <= t + 1e-12; });
        const double lambda = part->values.eigenvalues[std::size_t(i)];
        const double d = part->values.decay_rates[std::size_t(i)];
        const auto slope = [&](double time, double x, double y) {
          double f = 0;
          for (const TimedStrike& strike : strikes) {
            f += strike.impulse * force_at(strike.force, time - strike.time);
          }
          return f * excitation[i] - 2 * d * y - lambda * x;
        };
        const int steps = std::max(0, int(std::ceil((stop - t) / 6e-7)));
        const double h = steps > 0 ? (stop - t) / steps : 0;
        for (int k = 0; k < steps; ++k) {
          const double time = t + k * h;
          const double v1 = v, a1 = slope(time + 1e-15, q, v);
          const double v2 = v + h / 2 * a1, a2 = slope(time + h / 2, q + h / 2 * v1, v2);
          const double v3 = v + h / 2 * a2, a3 = slope(time + h / 2, q + h / 2 * v2, v3);
          const double v4 = v + h * a3, a4 = slope(time + h - 1e-15, q + h * v3, v4);
          q += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
          v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
        }
        t = std::max(t, stop);
        while (n < change_samples && double(n) / change_rate - readout.delays[r] <= stop + 1e-12) {
          if (double(n) / change_rate - readout.delays[r] >= 0) {
            out[r * change_samples + n] += readout.displacement(int(r), i) * q +
                                           readout.velocity(int(r), i) * v +
                                           readout.acceleration(int(r), i) * slope(t, q, v);
          }
          ++n;
        }
      }
    }
  }
  return out;
}

std::vector<float> streamed(const std::vector<ValuesFrom>& course,
                            const std::vector<TimedStrike>& strikes,
                            const Eigen::VectorXd& excitation, const modal::Readout& readout,
                            std::size_t block) {
  modal::StreamingRenderer renderer(2, change_rate);
  renderer.add_body(course[0].values.eigenvalues, course[0].values.decay_rates, readout);
  std::vector<float> out(2 * change_samples), part;
  std::size_t told = 1, struck = 0;
  for (std::size_t done = 0; done < change_samples;) {
    const std::size_t size = std::min(block, change_samples - done);
    const double now = double(done) / change_rate, end = double(done + size) / change_rate;
    for (; struck < strikes.size() && strikes[struck].time < end; ++struck) {
      renderer.strike(0, excitation * strikes[struck].impulse, strikes[struck].force,
                      strikes[struck].time - now);
    }
    for (; told < course.size() && course[told].time < end; ++told) {
      renderer.change(0, course[told].values.eigenvalues, course[told].values.decay_rates,
                      course[told].time - now);
    }
    part.resize(2 * size);
    renderer.render(part);
    for (std::size_t r = 0; r < 2; ++r) {
      std::copy_n(part.begin() + std::ptrdiff_t(r * size), size,
                  out.begin() + std::ptrdiff_t(r * change_samples + done));
    }
    done += size;
  }
  return out;
}

Values held(const Values& values, double damping, double stiffness) {
  Values more = values;
  for (std::size_t i = 0; i < more.eigenvalues.size(); ++i) {
    more.decay_rates[i] += damping * (1 + 0.3 * double(i));
    more.eigenvalues[i] += stiffness * (2 - 0.4 * double(i));
  }
  return more;
}

// A hand comes and goes and a spring is put under, between strikes and in the middle of contacts,
// at fractions of samples: as the equation of motion has it.
TEST(ChangingModes, FollowTheEquationOfMotion) {
  const Values values = free_values();
  modal::ContactForce burst{3e-3, {}};
  for (int i = 0; i < 40; ++i) burst.samples.push_back(400 * std::sin(i * i * 0.7) + 10);
  const std::vector<TimedStrike> strikes = {{0.0005, 1, {1.3e-3}},
                                            {0.006111, 0.4, {2e-3}},
                                            {0.0113, 0.7, burst},
                                            {0.017, -0.6, {1 / 310.0}}};
  // The third change makes modes critical that were not, and the other way round.
  const Values crossed = {values.eigenvalues, {omega(310) * 0.999, 80, 50, omega(500) * 0.9}};
  const std::vector<ValuesFrom> course = {{0, values},
                                          {0.0011234, held(values, 60, 0)},
                                          {0.004, held(values, 0, 2e5)},
                                          {0.0068, crossed},
                                          {0.01234567, held(values, 300, 4e5)},
                                          {0.0133, values},
                                          {0.01333, held(values, 20, 0)},
                                          {0.01777, held(values, 700, 1e5)},
                                          {0.021, values}};
  const Eigen::VectorXd excitation = Eigen::Vector4d(1, -0.7, 0.8, 1.4);
  const modal::Readout readout = mixed_readout();
  const auto expected = integrated(course, strikes, excitation, readout);
  double peak = 0;
  for (const double s : expected) peak = std::max(peak, std::abs(s));
  for (const std::size_t block : {std::size_t(64), std::size_t(1), std::size_t(700)}) {
    const auto sound = streamed(course, strikes, excitation, readout, block);
    double worst = 0;
    for (std::size_t n = 0; n < sound.size(); ++n) {
      worst = std::max(worst, std::abs(double(sound[n]) - expected[n]));
    }
    EXPECT_LT(worst, 1e-6 * peak) << block;
  }
}

// Values that stay as they are change nothing that can be heard.
TEST(ChangingModes, SameValuesAreNoChange) {
  const Values values = free_values();
  const std::vector<TimedStrike> strikes = {{0.0005, 1, {1.3e-3}}, {0.01, 0.4, {0}}};
  const Eigen::VectorXd excitation = Eigen::Vector4d(1, -0.7, 0.8, 1.4);
  const auto quiet = streamed({{0, values}}, strikes, excitation, mixed_readout(), 64);
  const auto changed = streamed({{0, values}, {0.0012, values}, {0.003, values}, {0.0101, values}},
                                strikes, excitation, mixed_readout(), 64);
  float peak = 0;
  for (const float s : quiet) peak = std::max(peak, std::abs(s));
  for (std::size_t n = 0; n < quiet.size(); ++n) ASSERT_NEAR(changed[n], quiet[n], 1e-6F * peak);
}

// A mode that is lifted beyond half the sample rate is silent, and begins anew when it comes back.
TEST(ChangingModes, ModesBeyondNyquistAreSilent) {
  modal::StreamingRenderer renderer(1, 8000);
  modal::Readout readout;
  readout.velocity = Eigen::MatrixXd::Ones(1, 1);
  readout.delays = {0};
  const std::vector<double> low = {square(omega(1000))}, high = {square(omega(4100))}, d = {5};
  renderer.add_body(low, d, readout);
  renderer.strike(0, Eigen::VectorXd::Ones(1), {0});
  std::vector<float> block(64);
  renderer.render(block);
  EXPECT_EQ(renderer.voices(), 1U);
  renderer.change(0, high, d);
  renderer.render(block);
  EXPECT_EQ(renderer.voices(), 0U);
  EXPECT_TRUE(std::all_of(block.begin(), block.end(), [](float s) { return s == 0; }));
  renderer.change(0, low, d);
  renderer.strike(0, Eigen::VectorXd::Ones(1), {0});
  renderer.render(block);
  EXPECT_FLOAT_EQ(block[0], 1);
}

// What another thread has prepared begins and sounds without memory being asked for.
TEST(ChangingModes, PreparedOnesAllocateNothing) {
  const Values values = free_values();
  modal::StreamingRenderer renderer(2, change_rate);
  renderer.add_body(values.eigenvalues, values.decay_rates, mixed_readout());
  const Eigen::VectorXd excitation = Eigen::Vector4d(1, -0.7, 0.8, 1.4);
  std::vector<std::unique_ptr<modal::StreamedStrike>> strikes;
  std::vector<std::unique_ptr<modal::StreamedChange>> changes;
  for (int i = 0; i < 60; ++i) {
    strikes.push_back(renderer.prepare_strike(0, excitation, {1e-3 + 1e-5 * i}));
    const Values other = i % 3 == 0 ? free_values() : held(values, 7000.0 * i, 1e5);
    changes.push_back(renderer.prepare_change(0, other.eigenvalues, other.decay_rates));
  }
  std::vector<float> block(2 * 64);
  const std::size_t before = test::allocated().times;
  std::size_t ended = 0;
  for (std::size_t i = 0; i < 60; ++i) {
    renderer.begin(std::move(strikes[i]), 1e-4);
    if (i % 2 == 0) renderer.begin(std::move(changes[i]), 7e-4);
    if (i % 5 == 0)
      if (changes[i / 5 * 2 + 1]) renderer.begin(std::move(changes[i / 5 * 2 + 1]), 5e-4);
    for (int k = 0; k < 2; ++k) renderer.render(block);
  }
  for (int k = 0; k < 10; ++k) renderer.render(block);
  EXPECT_EQ(test::allocated().times, before);
  while (renderer.take_ended_strike()) ++ended;
  EXPECT_EQ(ended, 60U);
  ended = 0;
  while (renderer.take_ended_change()) ++ended;
  EXPECT_GT(ended, 30U);
}

TEST(ChangingModes, RefuseWhatCannotBe) {
  const Values values = free_values();
  modal::StreamingRenderer renderer(2, change_rate);
  renderer.add_body(values.eigenvalues, values.decay_rates, mixed_readout());
  const auto change = [&](std::size_t body, const Values& to, double delay) {
    renderer.change(body, to.eigenvalues, to.decay_rates, delay);
  };
  EXPECT_THROW(change(1, values, 0), core::InputError);
  EXPECT_THROW(change(0, {{1, 2}, {1, 2}}, 0), core::InputError);
  EXPECT_THROW(change(0, {values.eigenvalues, {1, 2, -1, 3}}, 0), core::InputError);
  EXPECT_THROW(change(0, {values.eigenvalues, {1, 2, std::nan(""), 3}}, 0), core::InputError);
  EXPECT_THROW(change(0, values, -1), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
