// Radiation where it is hard: listeners at the surface, frequencies near zero and far above what
// the sources resolve, repeated modes, walls of no thickness to speak of, sizes from dust to halls.
#include <gtest/gtest.h>

#include <cmath>

#include "../synth/radiators.hpp"
#include "core/error.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/radiation/equivalent_sources.hpp"
#include "synth/radiation/rayleigh_integral.hpp"

namespace carillon::synth {
namespace {

constexpr double fixed_radius = 0.05;

radiation::EquivalentSourcesOptions coarse() {
  radiation::EquivalentSourcesOptions options;
  options.min_sources = options.max_sources = 100;
  return options;
}

solvers::modes::ModeSurface sphere(double radius = fixed_radius) {
  return curved_sphere(radius, Vec3::Zero(), 4, 3);
}

TEST(RadiationHard, ListenerOnTheSurface) {
  const auto modes = sphere_modes(sphere(), fixed_radius, 0, {1});
  const std::vector<modal::Listener> on = {{{0, 0, 1}}, {{0, 0, fixed_radius}}};
  const std::vector<modal::Listener> in = {{{0.01, 0, 0}}};
  const auto refusal = [](const auto& run) -> std::string {
    try {
      run();
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "no error";
  };
  const auto begins = [](const std::string& text, const std::string& with) {
    EXPECT_EQ(text.substr(0, with.size()), with);
  };
  // Which listener, how far, and how far would do. The first is far enough.
  begins(refusal([&] { heard_radiation(modes, on); }), "listener 1 is too near to the object, ");
  begins(refusal([&] { heard_radiation(modes, in); }), "listener 0 is inside the object, 0.03");
  EXPECT_NE(refusal([&] { heard_radiation(modes, on); }).find("meant from 0."), std::string::npos);
  begins(refusal([&] { modal::monopole(modes, on); }),
         "listener 1 is 0.05 m from the object's centre");
  const auto sheet =
      modes_with(disc(0.1, 1e-3), {1e6}, [](int, const Vec3&) { return Vec3(0, 0, 1); });
  const std::vector<modal::Listener> touching = {{{0.03, 0, 5e-4}}};
  begins(refusal([&] { radiation::rayleigh_pressure(sheet, touching); }), "listener 0 is ");
  EXPECT_NE(
      refusal([&] { radiation::rayleigh_pressure(sheet, touching); }).find(" m off the sheet"),
      std::string::npos);
}

// 1e-6 to 5: within 1 dB in the near field. Above, the residual tells: at 60 it is past the limit.
TEST(RadiationHard, FrequenciesFromNothingToFarTooHigh) {
  const std::vector<double> ka = {0, 1e-6, 1e-3, 5, 20, 60};
  const std::vector<modal::Listener> listeners = {{{0.02, 0.03, 0.06}}};
  for (const int order : {0, 1}) {
    const auto fit =
        heard_radiation(sphere_modes(sphere(), fixed_radius, order, ka), listeners, coarse());
    EXPECT_TRUE(fit.radiated.pressure.allFinite());
    for (const double d : fit.decay_rates) EXPECT_TRUE(d >= 0 && std::isfinite(d)) << d;
    for (Eigen::Index mode = 1; mode < 4; ++mode) {
      const double k = ka[std::size_t(mode)] / fixed_radius;
      const Complex expected = sphere_pressure(order, k, fixed_radius, listeners[0].position);
      EXPECT_NEAR(decibels(fit.radiated.pressure(0, mode), expected), 0, 1) << order << " " << k;
      EXPECT_LT(fit.residuals[std::size_t(mode)], 0.02);
    }
    // k = 0 is the limit.
    EXPECT_NEAR(std::abs(fit.radiated.pressure(0, 0) / fit.radiated.pressure(0, 1)), 1, 1e-4);
    EXPECT_GT(fit.residuals[5], radiation::residual_limit) << order;
  }
}

// Five-fold modes of a ball: the power of the whole cluster is that of any turned basis.
TEST(RadiationHard, RepeatedModesOfASymmetricBody) {
  const double lambda = std::pow(2 / fixed_radius * modal::speed_of_sound, 2);
  const auto shapes = [&](double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return modes_with(
        sphere(), std::vector<double>(5, lambda), [=](int mode, const Vec3& x) -> Vec3 {
          const Vec3 n = x.normalized();
          const double values[] = {1.5 * n[2] * n[2] - 0.5, std::sqrt(3) * n[0] * n[2],
                                   std::sqrt(3) * n[1] * n[2], std::sqrt(3) * n[0] * n[1],
                                   std::sqrt(3) / 2 * (n[0] * n[0] - n[1] * n[1])};
          if (mode == 1) return (c * values[1] + s * values[3]) * n;
          if (mode == 3) return (c * values[3] - s * values[1]) * n;
          return values[mode] * n;
        });
  };
  const std::vector<modal::Listener> listeners = {{{0.1, 0.2, 0.05}}, {{-0.3, 0.1, 0.7}}};
  const auto p = heard_radiation(shapes(0), listeners, coarse()).radiated.pressure;
  const auto q = heard_radiation(shapes(0.6), listeners, coarse()).radiated.pressure;
  for (Eigen::Index row = 0; row < 2; ++row) {
    EXPECT_NEAR(p.row(row).squaredNorm() / q.row(row).squaredNorm(), 1, 1e-5);
    // Addition theorem: the sum over the cluster does not depend on the direction.
    const double r = listeners[std::size_t(row)].position.norm();
    const Complex on_axis = sphere_pressure(2, 2 / fixed_radius, fixed_radius, {0, 0, r});
    EXPECT_NEAR(decibels(p.row(row).norm(), std::abs(on_axis)), 0, 0.5);
  }
}

TEST(RadiationHard, WallsOfAMicrometre) {
  const double k = 0.1 / fixed_radius;
  const auto modes = modes_with(disc(fixed_radius, 1e-6), {std::pow(k * modal::speed_of_sound, 2)},
                                [](int, const Vec3&) { return Vec3(0, 0, 1); });
  const std::vector<modal::Listener> listeners = {{{0, 0, 1}}};
  const auto fit = heard_radiation(modes, listeners);
  const Complex expected = modal::air_density * 8 / 3 * std::pow(fixed_radius, 3) * Complex(1, k) /
                           (4 * std::numbers::pi);
  EXPECT_NEAR(decibels(fit.radiated.pressure(0, 0), expected), 0, 1);
}

// Everything but the listener's side of a sphere of any size is a matter of scale.
TEST(RadiationHard, AMicrometreAndAHundredMetres) {
  for (const double radius : {1e-6, 100.0}) {
    const auto modes = sphere_modes(sphere(radius), radius, 1, {0.1, 2});
    const std::vector<modal::Listener> listeners = {{{0, radius, 3 * radius}}};
    const auto fit = heard_radiation(modes, listeners, coarse());
    for (Eigen::Index mode = 0; mode < 2; ++mode) {
      const double k = (mode == 0 ? 0.1 : 2) / radius;
      EXPECT_NEAR(decibels(fit.radiated.pressure(0, mode),
                           sphere_pressure(1, k, radius, listeners[0].position)),
                  0, 0.5);
    }
  }
}

TEST(RadiationHard, NoModesAndNoListeners) {
  const auto none = sphere_modes(sphere(), fixed_radius, 0, {});
  const std::vector<modal::Listener> listeners = {{{0, 0, 1}}};
  EXPECT_EQ(heard_radiation(none, listeners, coarse()).radiated.pressure.cols(), 0);
  const auto one = sphere_modes(sphere(), fixed_radius, 0, {1});
  EXPECT_EQ(heard_radiation(one, {}, coarse()).radiated.pressure.rows(), 0);
  auto broken = one;
  solvers::modes::ModeShapes::Rows shapes = one.shapes.at_nodes();
  shapes(0, 5) = std::nanf("");
  broken.shapes = solvers::modes::ModeShapes(shapes);
  EXPECT_THROW(heard_radiation(broken, listeners, coarse()), core::InputError);
  broken = one;
  broken.eigenvalues[0] = -1;
  EXPECT_THROW(heard_radiation(broken, listeners, coarse()), core::InputError);
}

// A mode that only slides along the surface makes no sound, and no NaN.
TEST(RadiationHard, MotionWithoutNormalVelocity) {
  const auto modes = modes_with(sphere(), {1e8}, [](int, const Vec3& x) -> Vec3 {
    return Vec3(-x[1], x[0], 0) / fixed_radius;
  });
  const std::vector<modal::Listener> listeners = {{{0, 0.1, 0.1}}};
  const auto fit = heard_radiation(modes, listeners, coarse());
  EXPECT_TRUE(std::isfinite(fit.residuals[0]));
  EXPECT_LT(std::abs(fit.radiated.pressure(0, 0)), 1e-3 * modal::air_density * fixed_radius);
}

}  // namespace
}  // namespace carillon::synth
