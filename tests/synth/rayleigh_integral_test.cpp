#include "synth/radiation/rayleigh_integral.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "tests/synth/radiators.hpp"

namespace carillon::synth {
namespace {

constexpr double fixed_radius = 0.1;
constexpr double thickness = 1e-3;

/// A disc that moves along its axis as a piston, at each k a.
solvers::modes::Modes piston(const std::vector<double>& ka) {
  std::vector<double> eigenvalues;
  for (const double value : ka) {
    eigenvalues.push_back(std::pow(value / fixed_radius * modal::speed_of_sound, 2));
  }
  return modes_with(disc(fixed_radius, thickness, 12, 96), eigenvalues,
                    [](int, const Vec3&) { return Vec3(0, 0, 1); });
}

// On the axis p = rho c v (exp(-i k z) - exp(-i k sqrt(z^2 + a^2))) (Pierce, eq. 5.7.3).
TEST(RayleighIntegral, IsThePistonOnItsAxis) {
  const std::vector<double> ka = {0.1, 1, 3, 8};
  const auto modes = piston(ka);
  const std::vector<modal::Listener> listeners = {{{0, 0, 0.03}}, {{0, 0, 0.2}}, {{0, 0, 2}}};
  const auto result = radiation::rayleigh_pressure(modes, listeners);
  for (std::size_t mode = 0; mode < ka.size(); ++mode) {
    const double k = ka[mode] / fixed_radius;
    for (std::size_t row = 0; row < listeners.size(); ++row) {
      const double z = listeners[row].position[2];
      const double height = z - thickness / 2;
      const Complex expected =
          modal::air_density / Complex(0, k) *
          (std::polar(1.0, -k * height) - std::polar(1.0, -k * std::hypot(height, fixed_radius))) *
          std::polar(1.0, k * z);
      const Complex found = result.pressure(Eigen::Index(row), Eigen::Index(mode));
      EXPECT_LT(std::abs(found - expected),
                0.02 * modal::air_density / k * std::min(1.0, k * fixed_radius * fixed_radius / z))
          << ka[mode] << " " << z;
    }
  }
}

// Far away 2 J1(x) / x with x = k a sin(angle).
TEST(RayleighIntegral, HasThePistonsDirectivity) {
  const double ka = 6, k = ka / fixed_radius;
  std::vector<modal::Listener> listeners;
  for (const double angle : {0.0, 0.2, 0.5, 0.9, 1.3}) {
    listeners.push_back({{50 * std::sin(angle), 0, 50 * std::cos(angle)}});
  }
  const auto result = radiation::rayleigh_pressure(piston({ka}), listeners);
  for (std::size_t row = 0; row < listeners.size(); ++row) {
    const double x = k * fixed_radius * listeners[row].position[0] / 50;
    const double expected = x == 0 ? 1 : 2 * std::cyl_bessel_j(1, x) / x;
    EXPECT_NEAR(std::abs(result.pressure(Eigen::Index(row), 0) / result.pressure(0, 0)),
                std::abs(expected), 0.005);
  }
}

// The other side hears the other face: the same pressure with the other sign.
TEST(RayleighIntegral, HasTwoSides) {
  const std::vector<modal::Listener> listeners = {{{0.1, 0.05, 0.4}}, {{0.1, 0.05, -0.4}}};
  const auto p = radiation::rayleigh_pressure(piston({2}), listeners).pressure;
  EXPECT_LT(std::abs(p(0, 0) + p(1, 0)), 1e-6 * std::abs(p(0, 0)));
}

TEST(RayleighIntegral, RefusesWhatIsNoSheet) {
  const std::vector<modal::Listener> listeners = {{{0, 0, 1}}};
  const auto refused = [&](const solvers::modes::ModeSurface& surface) {
    const auto modes = modes_with(surface, {1e6}, [](int, const Vec3& x) { return x; });
    try {
      radiation::rayleigh_pressure(modes, listeners);
      return std::string();
    } catch (const core::InputError& error) {
      EXPECT_NE(error.hint().find("equivalent_sources"), std::string::npos);
      return error.message();
    }
  };
  EXPECT_NE(refused(curved_sphere(0.1, Vec3::Zero(), 3, 2)).find("not a flat sheet"),
            std::string::npos);
  EXPECT_NE(refused(disc(0.1, 0.02)).find("0.02 m thick"), std::string::npos);
  solvers::modes::ModeSurface dish = disc(0.1, 1e-3);
  for (Vec3& node : dish.nodes) node[2] += 0.4 * node.head<2>().squaredNorm();
  EXPECT_NE(refused(dish).find("not a flat sheet"), std::string::npos);
  EXPECT_EQ(refused(disc(0.1, 1e-3)), "");
}

TEST(RayleighIntegral, RefusesListenersInTheSheet) {
  for (const Vec3& place : {Vec3(0.02, 0, 0), Vec3(0.5, 0, 1e-4), Vec3(0, 0, thickness / 2),
                            Vec3(0, 0, 1e-3), Vec3(std::nan(""), 0, 1)}) {
    const std::vector<modal::Listener> listeners = {{place}};
    EXPECT_THROW(radiation::rayleigh_pressure(piston({1}), listeners), core::InputError)
        << place.transpose();
  }
  // On the baffle beside the sheet there is pressure like anywhere else.
  const std::vector<modal::Listener> baffle = {{{0.5, 0, thickness / 2}}};
  EXPECT_GT(std::abs(radiation::rayleigh_pressure(piston({1}), baffle).pressure(0, 0)), 0);
}

}  // namespace
}  // namespace carillon::synth
