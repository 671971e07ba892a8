// Hertz's contact against the equation of motion and closed forms, the pulse that stands for it,
// and the noise burst.
#include "synth/contact/striker.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "curved_bodies.hpp"
#include "synth/contact/hertz_pulse.hpp"
#include "synth/contact/noise_burst.hpp"

namespace carillon::synth {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double infinite = std::numeric_limits<double>::infinity();

contact::Striker steel_ball() {
  return {"ball", 0.01, 0.006, 2e11, 0.29, 1.0, ""};
}
contact::StruckBody glass_block() {
  return {0.5, 6.2e10, 0.2, 0};
}

struct Course {
  double duration = 0, approach = 0, peak = 0, impulse = 0;
  std::vector<double> times, forces;
};

/// m x'' = -4/3 E* sqrt(R) x^1.5 from x = 0, x' = v until the bodies part, by classical
/// Runge-Kutta in units of the pulse.
Course integrate(double m, double radius, double modulus, double v) {
  const double k = 4.0 / 3 * modulus * std::sqrt(radius);
  const double unit = std::pow(m * m / (radius * modulus * modulus * v), 0.2);
  const double h = unit * 1e-4;
  const auto force = [&](double x) { return x > 0 ? k * x * std::sqrt(x) : 0.0; };
  Course course;
  double x = 0, u = v, t = 0;
  while (true) {
    course.times.push_back(t);
    course.forces.push_back(force(x));
    course.peak = std::max(course.peak, force(x));
    course.approach = std::max(course.approach, x);
    const auto a = [&](double at) { return -force(at) / m; };
    const double u1 = u, a1 = a(x);
    const double u2 = u + h / 2 * a1, a2 = a(x + h / 2 * u1);
    const double u3 = u + h / 2 * a2, a3 = a(x + h / 2 * u2);
    const double u4 = u + h * a3, a4 = a(x + h * u3);
    const double next = x + h / 6 * (u1 + 2 * u2 + 2 * u3 + u4);
    const double next_u = u + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    if (next <= 0) {
      course.duration = t + h * x / (x - next);
      course.impulse = m * (v - next_u);
      return course;
    }
    x = next;
    u = next_u;
    t += h;
  }
}

double magnitude(const std::vector<double>& times, const std::vector<double>& forces, double f) {
  std::complex<double> sum = 0;
  for (std::size_t n = 1; n < times.size(); ++n) {
    const auto value = [&](std::size_t i) {
      return forces[i] * std::polar(1.0, -2 * pi * f * times[i]);
    };
    sum += (times[n] - times[n - 1]) * (value(n) + value(n - 1)) / 2.0;
  }
  return std::abs(sum);
}

TEST(Hertz, ConstantIsThatOfTheTables) {
  // Johnson, Contact Mechanics, eq. 11.24: 2.87, and 2.94 in terms of the deepest approach.
  EXPECT_NEAR(contact::hertz_constant(), 2.868, 5e-4);
  EXPECT_NEAR(contact::hertz_constant() / std::pow(15.0 / 16, 0.4), 2.9433, 5e-5);
}

TEST(Hertz, AgreesWithTheEquationOfMotion) {
  for (const double speed : {0.01, 1.0, 20.0}) {
    const contact::HertzContact contact =
        contact::hertz_contact(steel_ball(), glass_block(), speed);
    const Course course = integrate(contact.mass, contact.radius, contact.modulus, speed);
    EXPECT_NEAR(contact.duration / course.duration, 1, 1e-5);
    EXPECT_NEAR(contact.approach / course.approach, 1, 1e-6);
    EXPECT_NEAR(contact.peak_force / course.peak, 1, 1e-6);
    EXPECT_NEAR(contact.impulse / course.impulse, 1, 1e-6);
  }
}

TEST(Hertz, CombinesMassesRadiiAndModuli) {
  const contact::Striker striker = steel_ball();
  contact::StruckBody body = glass_block();
  body.curvature = 1 / 0.018;
  const contact::HertzContact contact = contact::hertz_contact(striker, body, 1);
  EXPECT_NEAR(contact.mass, 0.01 * 0.5 / 0.51, 1e-15);
  EXPECT_NEAR(contact.radius, 0.0045, 1e-15);
  EXPECT_NEAR(1 / contact.modulus, (1 - 0.29 * 0.29) / 2e11 + (1 - 0.04) / 6.2e10, 1e-24);
}

TEST(Hertz, ARestitutionTakesFromTheReboundOnly) {
  contact::Striker striker = steel_ball();
  const double elastic = contact::hertz_contact(striker, glass_block(), 2).impulse;
  striker.restitution = 0;
  EXPECT_DOUBLE_EQ(contact::hertz_contact(striker, glass_block(), 2).impulse, elastic / 2);
}

TEST(Hertz, ABodyHeldFastMovesTheStrikerOnly) {
  contact::StruckBody body = glass_block();
  body.mass = infinite;
  EXPECT_DOUBLE_EQ(contact::hertz_contact(steel_ball(), body, 1).mass, 0.01);
}

TEST(Hertz, StrikersOrderByHardness) {
  double last = 0;
  for (const char* name : {"metal", "wood", "rubber", "finger"}) {
    const double duration =
        contact::hertz_contact(contact::preset_striker(name), glass_block(), 1).duration;
    EXPECT_GT(duration, last) << name;
    last = duration;
  }
  EXPECT_THROW(contact::preset_striker("rubbr"), core::InputError);
}

RC_GTEST_PROP(Hertz, TimeFollowsItsPowers, ()) {
  const auto power = [](int from, int to) {
    return std::pow(10.0, *rc::gen::inRange(from * 100, to * 100) / 100.0);
  };
  contact::Striker striker = steel_ball();
  striker.mass = power(-6, 3);
  contact::StruckBody body = glass_block();
  body.mass = infinite;
  const double speed = power(-3, 2), factor = power(0, 2);
  const double before = contact::hertz_contact(striker, body, speed).duration;
  RC_ASSERT(std::abs(contact::hertz_contact(striker, body, speed * factor).duration / before *
                         std::pow(factor, 0.2) -
                     1) < 1e-12);
  striker.mass *= factor;
  RC_ASSERT(std::abs(contact::hertz_contact(striker, body, speed).duration / before /
                         std::pow(factor, 0.4) -
                     1) < 1e-12);
}

TEST(Hertz, RefusesWhatIsNotPhysical) {
  const contact::StruckBody body = glass_block();
  for (const auto& change : std::vector<void (*)(contact::Striker&)>{
           [](contact::Striker& s) { s.mass = 0; }, [](contact::Striker& s) { s.radius = -1; },
           [](contact::Striker& s) { s.youngs_modulus = 0; },
           [](contact::Striker& s) { s.poisson_ratio = 0.6; },
           [](contact::Striker& s) { s.restitution = 1.1; },
           [](contact::Striker& s) { s.mass = std::nan(""); }}) {
    contact::Striker striker = steel_ball();
    change(striker);
    EXPECT_THROW(contact::hertz_contact(striker, body, 1), core::InputError);
  }
  EXPECT_THROW(contact::hertz_contact(steel_ball(), body, -1), core::InputError);
  EXPECT_THROW(contact::hertz_contact(steel_ball(), body, infinite), core::InputError);
  EXPECT_THROW(contact::hertz_contact(steel_ball(), {0, 1e9, 0.3, 0}, 1), core::InputError);
}

TEST(Curvature, OfASphereIsOneOverItsRadius) {
  for (const int order : {2, 3, 4}) {
    const auto surface = curved_sphere(0.05, {1, 2, 3}, 3, order);
    for (const std::int32_t face : {0, 5, 17}) {
      for (const Eigen::Vector3d& at : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.2, 0.3, 0.5),
                                        Eigen::Vector3d(0, 0.5, 0.5)}) {
        EXPECT_NEAR(contact::mean_curvature(surface, {face, at}) * 0.05, 1,
                    order == 2 ? 0.15 : 0.02);
      }
    }
  }
  EXPECT_NEAR(
      contact::mean_curvature(curved_sphere(0.05, {0, 0, 0}, 3, 3, true), {3, {0.3, 0.3, 0.4}}) *
          0.05,
      -1, 0.02);
  EXPECT_EQ(contact::mean_curvature(curved_sphere(0.05, {0, 0, 0}, 3, 1), {3, {0.3, 0.3, 0.4}}), 0);
}

TEST(Pulse, TheRaisedCosineDiffersFromHertzByWhatTheDocsSay) {
  // docs/sound/strikes.md: spectra of unit impulse and equal duration.
  const contact::HertzContact contact = contact::hertz_contact(steel_ball(), glass_block(), 1);
  const Course course = integrate(contact.mass, contact.radius, contact.modulus, 1);
  const double T = course.duration;
  std::vector<double> cosine, power;
  for (const double t : course.times) {
    cosine.push_back((1 - std::cos(2 * pi * t / T)) / T);
    power.push_back(std::pow(std::max(0.0, std::sin(pi * t / T)), 1.5));
  }
  const double area = magnitude(course.times, power, 0);
  const auto decibels = [](double ratio) { return 20 * std::log10(ratio); };
  const std::vector<std::pair<double, double>> documented = {
      {0.25, 0.05}, {0.5, 0.23}, {1.0, 1.08}, {1.5, 4.03}};
  for (const auto& [fT, difference] : documented) {
    const double hertz = magnitude(course.times, course.forces, fT / T) / contact.impulse;
    EXPECT_NEAR(decibels(magnitude(course.times, cosine, fT / T) / hertz), difference, 0.01) << fT;
    // The sine to the power 1.5 is no more than a likeness either.
    const double sine = magnitude(course.times, power, fT / T) / area;
    EXPECT_NEAR(decibels(sine / hertz), 0, fT <= 1 ? 0.3 : 1.4) << fT;
  }
  // The lobes behind the first zeros, as power over three of them.
  double hertz = 0, raised = 0;
  for (double fT = 3; fT < 6; fT += 0.1) {
    hertz += std::pow(magnitude(course.times, course.forces, fT / T) / contact.impulse, 2);
    raised += std::pow(magnitude(course.times, cosine, fT / T), 2);
  }
  EXPECT_NEAR(decibels(std::sqrt(raised / hertz)), -4.30, 0.05);
}

TEST(Pulse, OfHertzFollowsTheEquationOfMotion) {
  const contact::HertzContact contact = contact::hertz_contact(steel_ball(), glass_block(), 1);
  const Course course = integrate(contact.mass, contact.radius, contact.modulus, 1);
  const modal::ContactForce pulse = contact::hertz_pulse(course.duration);
  const double pieces = static_cast<double>(pulse.samples.size() - 1);
  for (std::size_t n = 0; n < course.times.size(); n += 97) {
    const double at = course.times[n] / course.duration * pieces;
    const auto k = std::min(static_cast<std::size_t>(at), pulse.samples.size() - 2);
    const double fraction = at - static_cast<double>(k);
    const double force = (1 - fraction) * pulse.samples[k] + fraction * pulse.samples[k + 1];
    EXPECT_NEAR(contact.impulse * force, course.forces[n], 6e-4 * course.peak) << n;
  }
  EXPECT_NEAR(modal::impulse_of(pulse), 1, 1e-12);
  // F_max T / (2 m v) = 5/8 x 2.9433; straight pieces have a little less area than the curve.
  EXPECT_NEAR(modal::peak_of(pulse) * course.duration, 0.625 * 2.94327, 2e-4);
  EXPECT_EQ(contact::hertz_pulse(0).samples.size(), 0u);
  EXPECT_THROW(contact::hertz_pulse(-1), core::InputError);
  EXPECT_THROW(contact::hertz_pulse(1e-320), core::InputError);
}

TEST(ContactForce, KnowsItsImpulseAndPeak) {
  EXPECT_EQ(modal::impulse_of({1e-3, {}}), 1);
  EXPECT_DOUBLE_EQ(modal::peak_of({1e-3, {}}), 2000);
  EXPECT_EQ(modal::peak_of({}), infinite);
  EXPECT_DOUBLE_EQ(modal::impulse_of({2, {1, -4, 3}}), -2);
  EXPECT_EQ(modal::peak_of({2, {1, -4, 3}}), 4);
}

/// |Fourier transform| squared of a force of straight pieces, by the trapezium rule on its samples
/// and the transform of a hat.
double spectrum(const modal::ContactForce& force, double f) {
  const double step = force.duration / static_cast<double>(force.samples.size() - 1);
  std::complex<double> sum = 0;
  for (std::size_t n = 0; n < force.samples.size(); ++n) {
    sum += force.samples[n] * std::polar(step, -2 * pi * f * step * static_cast<double>(n));
  }
  const double x = pi * f * step;
  const double hat = x == 0 ? 1 : std::pow(std::sin(x) / x, 2);
  return std::norm(sum) * hat * hat;
}

TEST(NoiseBurst, HasHinersTimesAndCutoffs) {
  EXPECT_DOUBLE_EQ(contact::burst_attack({0, 0}), 0.011);
  EXPECT_NEAR(contact::burst_attack({1, 0}), 0.001, 1e-15);
  EXPECT_DOUBLE_EQ(contact::burst_cutoff({0, 0}), 10000);
  EXPECT_DOUBLE_EQ(contact::burst_cutoff({0, 1}), 500);
}

TEST(NoiseBurst, ExcitesLikeAnIdealStrikeOnAverageBelowTheCutoff) {
  // Mean over draws against the Butterworth response |H|^2 = 1 / (1 + (f / fc)^6), the bilinear
  // transform's warping and the hat of straight pieces included.
  const double fs = 44100;
  const contact::NoiseBurst burst{0.9, 0.6};
  const std::vector<double> frequencies = {100, 1000, 3000, 4300, 8000};
  std::vector<double> mean(frequencies.size(), 0.0);
  const int draws = 1500;
  for (int k = 0; k < draws; ++k) {
    core::RandomStream random(1, static_cast<std::uint64_t>(k), "burst");
    const modal::ContactForce force = contact::noise_burst(burst, fs, random);
    for (std::size_t i = 0; i < mean.size(); ++i) {
      mean[i] += spectrum(force, frequencies[i]) / draws;
    }
  }
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const double f = frequencies[i];
    const double warped = std::tan(pi * f / fs) / std::tan(pi * contact::burst_cutoff(burst) / fs);
    const double hat = std::pow(std::sin(pi * f / fs) / (pi * f / fs), 4);
    // Each draw's power is exponentially distributed: its mean over 1500 has 2.6 %.
    EXPECT_NEAR(mean[i] / (hat / (1 + std::pow(warped, 6))), 1, 0.13) << f;
  }
}

TEST(NoiseBurst, LastsTwiceTheRiseAndTheFiltersRing) {
  core::RandomStream random(0, 0, "burst");
  const modal::ContactForce force = contact::noise_burst({0.5, 0.0}, 44100, random);
  EXPECT_NEAR(force.duration, 0.012 + std::log(1e6) / (pi * 10000), 3 / 44100.0);
  EXPECT_EQ(force.samples.front(), 0);
  EXPECT_EQ(force.samples.back(), 0);
  EXPECT_NEAR(force.duration * 44100, static_cast<double>(force.samples.size() - 1), 1e-9);
}

TEST(NoiseBurst, IsAFunctionOfItsStream) {
  core::RandomStream first(3, 4, "burst"), again(3, 4, "burst"), other(3, 5, "burst");
  const auto force = contact::noise_burst({}, 44100, first).samples;
  EXPECT_EQ(force, contact::noise_burst({}, 44100, again).samples);
  EXPECT_NE(force, contact::noise_burst({}, 44100, other).samples);
}

TEST(NoiseBurst, RefusesWhatIsOutsideItsRange) {
  core::RandomStream random(0, 0, "burst");
  EXPECT_THROW(contact::noise_burst({1.1, 0}, 44100, random), core::InputError);
  EXPECT_THROW(contact::noise_burst({0, std::nan("")}, 44100, random), core::InputError);
  EXPECT_THROW(contact::noise_burst({0, 0}, 0, random), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
