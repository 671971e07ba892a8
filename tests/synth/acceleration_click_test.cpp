// Sound of a rigid body's acceleration: against the oscillating sphere's radiation in the frequency
// domain, the low-frequency dipole, and its symmetries.
#include "synth/contact/acceleration_click.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "curved_bodies.hpp"
#include "synth/modal/modal_response.hpp"

namespace carillon::synth {
namespace {

constexpr double pi = std::numbers::pi;
using Complex = std::complex<double>;

contact::RigidSource sphere(double radius, double mass) {
  return {Vec3::Zero(), Eigen::Matrix3d::Identity(), Vec3::Constant(radius), mass};
}

double moving_mass(double radius, double mass) {
  return mass + modal::air_density * 2 * pi / 3 * radius * radius * radius;
}

/// Spherical Hankel function of order 1 for exp(i w t), outgoing, and its derivative.
Complex hankel(double x) {
  return Complex(std::sin(x) / (x * x) - std::cos(x) / x, std::cos(x) / (x * x) + std::sin(x) / x);
}
Complex hankel_slope(double x) {
  const Complex zeroth(std::sin(x) / x, std::cos(x) / x);
  return zeroth - 2.0 / x * hankel(x);
}

/// Transform of the raised cosine of unit area over 0 <= t <= T.
Complex pulse(double w, double T) {
  const double x = w * T / (2 * pi);
  const double s = w * T / 2;
  return std::polar(std::sin(s) / s / (1 - x * x), -s);
}

TEST(Click, SpectrumIsThatOfAnOscillatingSphere) {
  // p = -i rho c U cos(theta) h1(k r) / h1'(k a) (Morse and Ingard, Theoretical Acoustics, 7.1).
  const double a = 0.03, m = 0.1, T = 2e-4, r = 0.2, fs = 4e6;
  const Vec3 impulse(0, 0, 0.05);
  const Vec3 listener = r * Vec3(0, std::sin(0.7), std::cos(0.7));
  const auto samples =
      contact::acceleration_click(sphere(a, m), impulse, {.duration = T}, listener, fs, 20000);
  for (const double f : {500.0, 2000.0, 6000.0, 9000.0}) {
    const double w = 2 * pi * f, k = w / modal::speed_of_sound;
    Complex sum = 0;
    for (std::size_t n = 0; n < samples.size(); ++n) {
      // The middle of the interval that a sample is the mean of.
      sum += static_cast<double>(samples[n]) / fs *
             std::polar(1.0, -w * (static_cast<double>(n) - 0.5) / fs);
    }
    const Complex velocity = 0.05 / moving_mass(a, m) * pulse(w, T) / Complex(0, w);
    const Complex exact = Complex(0, -modal::air_density * modal::speed_of_sound) * velocity *
                          std::cos(0.7) * hankel(k * r) / hankel_slope(k * a);
    EXPECT_LT(std::abs(sum - exact) / std::abs(exact), 2e-4) << f << " Hz";
  }
}

TEST(Click, IsADipoleWhereTheSphereIsSmallAgainstTheWave) {
  // p = rho a^3 cos(theta) / 2 (A'(tau) / (c r) + A(tau) / r^2).
  const double a = 0.002, m = 0.01, T = 2e-3, fs = 1e6;
  for (const double r : {0.01, 1.0}) {
    const auto samples =
        contact::acceleration_click(sphere(a, m), {0, 0, 1}, {.duration = T}, {0, 0, r}, fs, 5200);
    const double delay = (r - a) / modal::speed_of_sound;
    double worst = 0, peak = 0;
    for (std::size_t n = 0; n < samples.size(); ++n) {
      // The sphere's own lag: a / c.
      const double t = (static_cast<double>(n) - 0.5) / fs - delay - a / modal::speed_of_sound;
      const bool on = t > 0 && t < T;
      const double force = on ? (1 - std::cos(2 * pi * t / T)) / T : 0;
      const double slope = on ? 2 * pi / T * std::sin(2 * pi * t / T) / T : 0;
      const double dipole = modal::air_density * a * a * a / 2 / moving_mass(a, m) *
                            (slope / (modal::speed_of_sound * r) + force / (r * r));
      worst = std::max(worst, std::abs(dipole - static_cast<double>(samples[n])));
      peak = std::max(peak, std::abs(dipole));
    }
    EXPECT_LT(worst / peak, 0.02) << r;
  }
}

TEST(Click, SumsToThePotentialOfTheMotionThatRemains) {
  // Far pressure integrates to zero; what is left is rho a^3 cos(theta) dv / (2 r^2).
  const double a = 0.05, m = 0.3, fs = 44100;
  for (const double T : {0.0, 3e-4}) {
    const auto samples = contact::acceleration_click(sphere(a, m), {0, 0, 2}, {.duration = T},
                                                     {0, 0.3, 0.4}, fs, 4000);
    double sum = 0, size = 0;
    for (const float p : samples) {
      sum += static_cast<double>(p) / fs;
      size += std::abs(static_cast<double>(p)) / fs;
    }
    const double left = modal::air_density * a * a * a * 0.8 * (2 / moving_mass(a, m)) / (2 * 0.25);
    EXPECT_NEAR(sum, left, 1e-6 * size);
    EXPECT_GT(size, 2 * left);
  }
}

RC_GTEST_PROP(Click, IsSilentBeforeSoundCanArrive, ()) {
  const auto power = [](int from, int to) {
    return std::pow(10.0, *rc::gen::inRange(from * 100, to * 100) / 100.0);
  };
  const double a = power(-3, 1), r = a * power(0, 3), fs = 44100;
  const double T = *rc::gen::element(0.0, 1e-6, 1e-4, 1e-2);
  const auto samples =
      contact::acceleration_click(sphere(a, 1), {0, 0, 1}, {.duration = T}, {0, 0, r}, fs, 20000);
  const double arrival = (r - a) / modal::speed_of_sound;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    if (static_cast<double>(n) / fs < arrival) RC_ASSERT(samples[n] == 0.0f);
    RC_ASSERT(std::isfinite(samples[n]));
  }
}

TEST(Click, FollowsTheCosineTheImpulseAndItsSign) {
  const contact::RigidSource source = sphere(0.02, 0.05);
  const auto at = [&](const Vec3& impulse, double angle) {
    return contact::acceleration_click(source, impulse, {.duration = 2e-4},
                                       Vec3(std::sin(angle), 0, std::cos(angle)), 44100, 400);
  };
  const auto ahead = at({0, 0, 1}, 0);
  const auto aside = at({0, 0, 1}, 1.0);
  const auto behind = at({0, 0, 1}, pi);
  const auto reversed = at({0, 0, -3}, 0);
  const auto square = at({0, 1, 0}, 0.3);
  double peak = 0;
  for (const float p : ahead) peak = std::max(peak, std::abs(static_cast<double>(p)));
  EXPECT_GT(peak, 1e-3);
  for (std::size_t n = 0; n < ahead.size(); ++n) {
    const double p = ahead[n];
    EXPECT_NEAR(aside[n], p * std::cos(1.0), 1e-6 * peak);
    EXPECT_NEAR(behind[n], -p, 1e-6 * peak);
    EXPECT_NEAR(reversed[n], -3 * p, 1e-6 * peak);
    EXPECT_EQ(square[n], 0.0f);
  }
}

TEST(Click, FallsWithDistance) {
  // 1 / r where the near field is over; whole samples of flight between the two.
  const double fs = 44100, a = 0.02, step = modal::speed_of_sound / fs;
  const double near = a + 1000 * step, far = a + 3000 * step;
  const auto first = contact::acceleration_click(sphere(a, 1), {0, 0, 1}, {.duration = 1e-4},
                                                 {0, 0, near}, fs, 4000);
  const auto second = contact::acceleration_click(sphere(a, 1), {0, 0, 1}, {.duration = 1e-4},
                                                  {0, 0, far}, fs, 4000);
  const auto peak = [](const auto& p) {
    return static_cast<double>(*std::max_element(p.begin(), p.end()));
  };
  EXPECT_NEAR(peak(first) / peak(second), far / near, 2e-3 * far / near);
}

TEST(Click, ASampledForceSoundsLikeItsFormula) {
  const double T = 3e-4;
  modal::ContactForce sampled{.duration = T};
  for (int k = 0; k <= 400; ++k) sampled.samples.push_back(modal::contact_force(T, T * k / 400));
  const auto make = [&](const modal::ContactForce& force) {
    return contact::acceleration_click(sphere(0.03, 0.1), {0, 0, 1}, force, {0, 0.1, 0.2}, 44100,
                                       300);
  };
  const auto exact = make({.duration = T});
  const auto pieces = make(sampled);
  const double peak = static_cast<double>(*std::max_element(exact.begin(), exact.end()));
  for (std::size_t n = 0; n < exact.size(); ++n) EXPECT_NEAR(exact[n], pieces[n], 1e-4 * peak);
}

TEST(EquivalentSphere, OfASphereIsItself) {
  const contact::RigidSource source =
      contact::rigid_source(curved_sphere(0.05, {1, 2, 3}, 4, 3), 2);
  EXPECT_LT((source.centre - Vec3(1, 2, 3)).norm(), 1e-6);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(source.radii[i] / 0.05, 1, 0.01);
}

TEST(EquivalentSphere, HasLambsAddedMasses) {
  // Disc: 8/3 rho R^3 along its axis (Lamb, Hydrodynamics, 102 and 114.4), none across it.
  const Vec3 disc = contact::equivalent_radii({0.2, 0.2, 2e-6});
  EXPECT_NEAR(2 * pi * std::pow(disc[2], 3) / (8.0 / 3 * 0.008), 1, 1e-4);
  EXPECT_LT(disc[0], 0.02);
  // Prolate spheroid of axes 2 : 1 in closed form (Lamb, 114, eq. 4 and 6).
  const double e = std::sqrt(0.75), log = std::log((1 + e) / (1 - e));
  const double along = 2 * (1 - e * e) / (e * e * e) * (log / 2 - e);
  const double across = 1 / (e * e) - (1 - e * e) / (2 * e * e * e) * log;
  const Vec3 egg = contact::equivalent_radii({1, 1, 2});
  const double volume = 4 * pi / 3 * 2;
  EXPECT_NEAR(2 * pi * std::pow(egg[2], 3) / volume, 2 / (2 - along), 1e-12);
  EXPECT_NEAR(2 * pi * std::pow(egg[0], 3) / volume, 2 / (2 - across), 1e-12);
}

TEST(EquivalentSphere, TurnsWithTheBody) {
  auto surface = curved_sphere(1, {0, 0, 0}, 4, 2);
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.4, Vec3::UnitX()) * Eigen::AngleAxisd(1.1, Vec3::UnitZ())).matrix();
  auto turned = surface;
  for (std::size_t n = 0; n < surface.nodes.size(); ++n) {
    surface.nodes[n] = surface.nodes[n].cwiseProduct(Vec3(0.01, 0.03, 0.06));
    turned.nodes[n] = turn * surface.nodes[n];
  }
  const auto click = [](const solvers::modes::ModeSurface& body, const Vec3& impulse,
                        const Vec3& at) {
    return contact::acceleration_click(contact::rigid_source(body, 0.2), impulse,
                                       {.duration = 1e-4}, at, 44100, 200);
  };
  const Vec3 impulse(0.3, -0.2, 0.5), at(0.1, 0.2, 0.15);
  const auto one = click(surface, impulse, at);
  const auto two = click(turned, turn * impulse, turn * at);
  const double peak = static_cast<double>(*std::max_element(one.begin(), one.end()));
  for (std::size_t n = 0; n < one.size(); ++n) EXPECT_NEAR(one[n], two[n], 1e-5 * peak);
}

TEST(Click, RefusesAListenerInsideAndABodyWithoutMass) {
  EXPECT_THROW(contact::acceleration_click(sphere(0.1, 1), {0, 0, 1}, {}, {0, 0, 0.05}, 44100, 10),
               core::InputError);
  EXPECT_THROW(contact::acceleration_click(sphere(0.1, 0), {0, 0, 1}, {}, {0, 0, 1}, 44100, 10),
               core::InputError);
  EXPECT_THROW(
      contact::acceleration_click(sphere(0.1, 1), {0, 0, std::nan("")}, {}, {0, 0, 1}, 44100, 10),
      core::InputError);
  EXPECT_THROW(contact::rigid_source(curved_sphere(1, {0, 0, 0}, 2, 1, true), 1), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
