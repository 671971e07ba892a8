#include "synth/radiation/equivalent_sources.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/radiation/fit_cache.hpp"
#include "synth/surface/outer_triangles.hpp"
#include "synth/surface/point_flux.hpp"
#include "synth/surface/surface_patches.hpp"
#include "tests/synth/radiators.hpp"

namespace carillon::synth {
namespace {

constexpr double fixed_radius = 0.05;
const Vec3 origin = Vec3::Zero();

solvers::modes::ModeSurface sphere() {
  return curved_sphere(fixed_radius, origin, 4, 3);
}

Complex undelayed(const Complex& pressure, double k, double distance) {
  return pressure * std::polar(1.0, k * distance);
}

TEST(PointFlux, GradientOfTheSolidAngle) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 a = vector(), b = vector(), c = vector(), observer = vector();
    const auto angle = [&](const Vec3& y) {
      return solvers::mesh::solid_angle(a - y, b - y, c - y);
    };
    const Vec3 found = surface::solid_angle_gradient(a - observer, b - observer, 0) +
                       surface::solid_angle_gradient(b - observer, c - observer, 0) +
                       surface::solid_angle_gradient(c - observer, a - observer, 0);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 step = 1e-5 * Vec3::Unit(axis);
      double difference = angle(observer + step) - angle(observer - step);
      difference -= 4 * std::numbers::pi * std::round(difference / (4 * std::numbers::pi));
      EXPECT_NEAR(found[axis], difference / 2e-5, 1e-5 * (1 + std::abs(found[axis])));
    }
  }
}

TEST(OuterTriangles, AreClosedAndLeaveCavitiesOut) {
  solvers::modes::ModeSurface surface = sphere();
  append(surface, curved_sphere(0.03, origin, 2, 3, true));
  const surface::OuterTriangles cut = surface::outer_triangles(surface, 3000);
  EXPECT_GE(cut.size(), 3000u);
  Vec3 sum = origin;
  for (const Vec3& area : cut.area_vectors) sum += area;
  EXPECT_LT(sum.norm(), 1e-12 * cut.area);
  for (const auto& sides : cut.neighbours) {
    for (const int neighbour : sides) EXPECT_GE(neighbour, 0);
  }
  EXPECT_NEAR(cut.area, 4 * std::numbers::pi * fixed_radius * fixed_radius, 2e-3 * cut.area);
  EXPECT_NEAR(solvers::mesh::winding_number(cut.mesh, {0, 0, 0.04}), 1, 1e-9);
  EXPECT_NEAR(solvers::mesh::winding_number(cut.mesh, {0, 0, 0.06}), 0, 1e-9);
  EXPECT_NEAR(surface::distance_from(cut.mesh, {0, 0, 0.08}), 0.03, 1e-4);
}

// Pulsating and oscillating sphere and the next two multipoles, near and far, amplitude and phase.
TEST(EquivalentSources, AreTheSphereOfEveryOrder) {
  const std::vector<double> ka = {0.1, 0.5, 1, 2, 3, 4, 5};
  const std::vector<modal::Listener> listeners = {{{0.02, 0.03, 0.06}}, {{0.3, -0.2, 0.9}}};
  for (int order = 0; order < 4; ++order) {
    const auto fit = heard_radiation(sphere_modes(sphere(), fixed_radius, order, ka), listeners);
    for (std::size_t mode = 0; mode < ka.size(); ++mode) {
      EXPECT_LT(fit.residuals[mode], 0.02) << order << " " << ka[mode];
      RecordProperty(fmt::format("residual_order_{}_ka_{}", order, ka[mode]),
                     fmt::format("{:.4f}", fit.residuals[mode]));
      for (std::size_t row = 0; row < listeners.size(); ++row) {
        const Vec3& x = listeners[row].position;
        const double k = ka[mode] / fixed_radius;
        // Of the field of high orders at low k nothing is left far away but what the fit is off.
        if (order >= 2 && row == 1 && ka[mode] < 1) continue;
        const Complex expected = undelayed(sphere_pressure(order, k, fixed_radius, x), k, x.norm());
        const Complex found = fit.radiated.pressure(Eigen::Index(row), Eigen::Index(mode));
        const double error = decibels(found, expected);
        EXPECT_NEAR(error, 0, 0.35) << order << " " << ka[mode] << " " << row;
        RecordProperty(
            fmt::format("dB_order_{}_ka_{}_{}", order, ka[mode], row == 0 ? "near" : "far"),
            fmt::format("{:+.3f}", error));
        EXPECT_NEAR(std::arg(found / expected), 0, 0.03) << order << " " << ka[mode] << " " << row;
      }
    }
  }
}

// Where the air inside would resonate (zeros of j0 and j1) the outside does not notice.
TEST(EquivalentSources, PassInnerResonances) {
  const std::vector<double> ka = {3.1, std::numbers::pi, 3.2, 4.45, 4.493409458, 4.53};
  const std::vector<modal::Listener> listeners = {{{0.1, -0.2, 0.4}}};
  for (const int order : {0, 1}) {
    const auto fit = heard_radiation(sphere_modes(sphere(), fixed_radius, order, ka), listeners);
    for (std::size_t mode = 0; mode < ka.size(); ++mode) {
      const double k = ka[mode] / fixed_radius;
      const Complex expected = sphere_pressure(order, k, fixed_radius, listeners[0].position);
      EXPECT_NEAR(decibels(fit.radiated.pressure(0, Eigen::Index(mode)), expected), 0, 0.15);
      EXPECT_LT(fit.residuals[mode], 0.01);
    }
  }
}

// A rigid thin disc that moves along its axis: dipole of the added mass 8/3 rho a^3 (Lamb).
TEST(EquivalentSources, AreTheDipoleOfAThinDisc) {
  for (const double thickness : {1e-3, 1e-4}) {
    const double ka = 0.1, k = ka / fixed_radius;
    const auto modes =
        modes_with(disc(fixed_radius, thickness), {std::pow(k * modal::speed_of_sound, 2)},
                   [](int, const Vec3&) { return Vec3(0, 0, 1); });
    const std::vector<modal::Listener> listeners = {{{0, 0, 1}}, {{1, 0, 1}}, {{0, 0, -1}}};
    const auto fit = heard_radiation(modes, listeners);
    const double moment =
        modal::air_density * (8.0 / 3 * std::pow(fixed_radius, 3) +
                              std::numbers::pi * fixed_radius * fixed_radius * thickness);
    for (std::size_t row = 0; row < listeners.size(); ++row) {
      const Vec3& x = listeners[row].position;
      const double r = x.norm();
      const Complex expected = moment * Complex(1 / r, k) * (x[2] / r) / (4 * std::numbers::pi * r);
      const Complex found = fit.radiated.pressure(Eigen::Index(row), 0);
      EXPECT_NEAR(decibels(found, expected), 0, 0.5) << thickness << " " << row;
      EXPECT_NEAR(std::arg(found / expected), 0, 0.03) << thickness << " " << row;
      RecordProperty(fmt::format("dB_thickness_{}_listener_{}", thickness, row),
                     fmt::format("{:+.3f}", decibels(found, expected)));
    }
  }
}

// The same sound from a breathing ball far smaller than the wavelength as from its volume velocity.
TEST(EquivalentSources, AreTheMonopoleOfASmallBall) {
  const auto modes = sphere_modes(sphere(), fixed_radius, 0, {0.01, 0.02, 0.02});
  const std::vector<modal::Listener> listeners = {{{0.3, 0.4, 0}}};
  const std::vector<double> decay = {3, 20, 500};  // the last dies within a few periods
  const auto fit = heard_radiation(modes, listeners);
  const modal::Readout near = radiation::pressure_readout(fit.radiated, modes, decay);
  const modal::Strike strike{{0, {0.3, 0.3, 0.4}}, Vec3(-1, -1, -1).normalized(), 0.01, {1e-3}};
  const auto sound = [&](const modal::Readout& readout) {
    return modal::synthesize(modal::ring_down(modes, decay, strike, readout), strike.force, 8000,
                             2000);
  };
  const auto found = sound(near), expected = sound(modal::monopole(modes, listeners));
  double worst = 0, peak = 0;
  for (std::size_t n = 0; n < expected.size(); ++n) {
    worst = std::max(worst, std::abs(double(found[n]) - expected[n]));
    peak = std::max(peak, std::abs(double(expected[n])));
  }
  EXPECT_GT(peak, 0);
  EXPECT_LT(worst, 0.03 * peak);
  EXPECT_NEAR(near.delays[0], 0.5 / modal::speed_of_sound, 1e-9);
}

// Power over twice the energy: of spheres that breathe and that move to and fro (Pierce, Acoustics,
// sections 4-1 and 4-2), their specific resistances rho c x^2 / (1 + x^2) and rho c x^4 / (4 +
// x^4).
TEST(EquivalentSources, DampTheModesOfASphereAsTheyRadiate) {
  const std::vector<double> ka = {0.1, 0.5, 1, 2, 4};
  const std::vector<modal::Listener> listeners = {{{0, 0, 1}}};
  for (const int order : {0, 1}) {
    const auto modes = sphere_modes(sphere(), fixed_radius, order, ka);
    const auto fit = heard_radiation(modes, listeners);
    for (std::size_t mode = 0; mode < ka.size(); ++mode) {
      const double x = ka[mode];
      const double resistance =
          modal::air_density * modal::speed_of_sound *
          (order == 0 ? x * x / (1 + x * x) : std::pow(x, 4) / (4 + std::pow(x, 4)));
      const double area = 4 * std::numbers::pi * fixed_radius * fixed_radius / (order == 0 ? 1 : 3);
      EXPECT_NEAR(fit.decay_rates[mode] / (resistance * area / 2), 1, 0.05) << order << " " << x;
    }
  }
}

TEST(EquivalentSources, TurnWithTheBody) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
  auto modes = sphere_modes(sphere(), fixed_radius, 2, {0.7, 2.5});
  std::vector<modal::Listener> listeners = {{{0.02, 0.05, 0.12}}};
  const auto before = heard_radiation(modes, listeners);
  for (Vec3& node : modes.surface.nodes) node = turn * node;
  modes.shapes = turned_shapes(modes.shapes, turn);
  listeners[0].position = turn * listeners[0].position;
  const auto after = heard_radiation(modes, listeners);
  for (Eigen::Index mode = 0; mode < 2; ++mode) {
    const Complex ratio = after.radiated.pressure(0, mode) / before.radiated.pressure(0, mode);
    EXPECT_LT(std::abs(ratio - 1.0), 0.02);
  }
}

// What a disc of sharp edges sends out is the same through a near sphere and through a far one.
TEST(EquivalentSources, KeepPower) {
  const double k = 1.5 / fixed_radius, omega = k * modal::speed_of_sound;
  const auto modes = modes_with(disc(fixed_radius, 0.02), {omega * omega},
                                [](int, const Vec3& x) { return Vec3(x[0], 0, 0.05 + x[1]); });
  constexpr int rings = 16, turns = 32;
  const double near = 0.09, far = 2, step = 1e-4;
  std::vector<modal::Listener> listeners;
  for (int i = 0; i < rings; ++i) {
    const double z = -1 + (2 * i + 1.0) / rings;
    for (int j = 0; j < turns; ++j) {
      const double angle = 2 * std::numbers::pi * j / turns;
      const double across = std::sqrt(1 - z * z);
      const Vec3 direction(across * std::cos(angle), across * std::sin(angle), z);
      for (const double r : {near - step, near + step, far}) listeners.push_back({r * direction});
    }
  }
  const auto fit = heard_radiation(modes, listeners);
  double near_power = 0, far_power = 0;
  for (Eigen::Index i = 0; i < rings * turns; ++i) {
    const auto at = [&](Eigen::Index row) {
      return fit.radiated.pressure(row, 0) *
             std::polar(1.0, -omega * fit.radiated.delays[std::size_t(row)]);
    };
    const Complex inner = at(3 * i), outer = at(3 * i + 1);
    const Complex velocity =
        (outer - inner) / (2 * step) / (-Complex(0, 1) * omega * modal::air_density);
    near_power += std::real(0.5 * (inner + outer) * std::conj(velocity)) * near * near;
    far_power +=
        std::norm(at(3 * i + 2)) / (modal::air_density * modal::speed_of_sound) * far * far;
  }
  EXPECT_NEAR(near_power / far_power, 1, 0.02);
  // Means over the sphere times its area and a half; what is left decays at half of it per energy.
  const double power = 4 * std::numbers::pi / (rings * turns) * far_power / 2;
  EXPECT_NEAR(fit.decay_rates[0] / (power * omega * omega), 1, 0.03);
}

TEST(EquivalentSources, ALinearMapWithinRepeatedModes) {
  const double lambda = std::pow(1.3 / fixed_radius * modal::speed_of_sound, 2), turn = 0.7;
  const auto shapes = [&](double angle) {
    return modes_with(sphere(), {lambda, lambda}, [=](int mode, const Vec3& x) -> Vec3 {
      const double phase = angle + mode * std::numbers::pi / 2;
      return (x[0] * std::cos(phase) + x[1] * std::sin(phase)) * x;
    });
  };
  const std::vector<modal::Listener> listeners = {{{0.1, 0.2, 0.05}}};
  const auto p = heard_radiation(shapes(0), listeners).radiated.pressure;
  const auto q = heard_radiation(shapes(turn), listeners).radiated.pressure;
  EXPECT_LT(std::abs(std::cos(turn) * p(0, 0) + std::sin(turn) * p(0, 1) - q(0, 0)),
            1e-5 * std::abs(q(0, 0)));
}

TEST(EquivalentSources, ListenersMustBeInTheOpenAir) {
  const auto modes = sphere_modes(sphere(), fixed_radius, 0, {1});
  for (const Vec3& place :
       {Vec3(0, 0, 0.02), Vec3(0, 0, fixed_radius), Vec3(0, 0, 0.0501), Vec3(0, 0, std::nan(""))}) {
    const std::vector<modal::Listener> listeners = {{{0, 0, 1}}, {place}};
    try {
      heard_radiation(modes, listeners);
      FAIL() << place.transpose();
    } catch (const core::InputError& error) {
      EXPECT_NE(error.message().find("listener 1"), std::string::npos) << error.message();
    }
  }
}

TEST(EquivalentSources, AreKeptInAFile) {
  const core::TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path();
  const auto modes = sphere_modes(sphere(), fixed_radius, 1, {1, 2});
  const std::vector<modal::Listener> listeners = {{{0, 0.1, 1}}, {{0.07, 0.02, 0}}};
  radiation::EquivalentSourcesOptions options;
  options.min_sources = options.max_sources = 60;
  const auto files = [&] { return std::distance(std::filesystem::directory_iterator(folder), {}); };
  const auto fit = [&] {
    return radiation::SourceField(radiation::cached_equivalent_sources(modes, options, folder));
  };
  const radiation::SourceField computed = fit();
  ASSERT_EQ(files(), 1);
  const auto file = std::filesystem::directory_iterator(folder)->path();
  const radiation::SourceField kept = fit();
  const radiation::ModalPressure pressure = computed.pressure_at(listeners);
  EXPECT_EQ(kept.pressure_at(listeners).pressure, pressure.pressure);
  EXPECT_EQ(kept.pressure_at(listeners).delays, pressure.delays);
  EXPECT_EQ(kept.sources().residuals, computed.sources().residuals);
  EXPECT_EQ(kept.sources().decay_rates, computed.sources().decay_rates);
  EXPECT_EQ(kept.sources().layers, computed.sources().layers);
  EXPECT_EQ(kept.sources().patches, computed.sources().patches);
  EXPECT_THROW(kept.pressure_at(std::vector<modal::Listener>{{{0, 0, 0.051}}}), core::InputError);
  // A torn file is not believed.
  const auto size = std::filesystem::file_size(file);
  for (const std::streamoff torn : {60, 100000}) {
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(torn).put('?');
    EXPECT_EQ(fit().pressure_at(listeners).pressure, pressure.pressure);
  }
  std::filesystem::resize_file(file, size / 2);
  EXPECT_EQ(fit().pressure_at(listeners).pressure, pressure.pressure);
  std::filesystem::resize_file(file, 3);
  EXPECT_EQ(fit().pressure_at(listeners).pressure, pressure.pressure);
  // Other options are another fit; other listeners are not.
  options.min_sources = options.max_sources = 61;
  fit();
  EXPECT_EQ(files(), 2);
}

// Wherever the listener and however many at a time: one fit's field, that of the closed form.
TEST(EquivalentSources, OneFitServesListenersAnywhere) {
  const auto modes = sphere_modes(sphere(), fixed_radius, 1, {0.5, 0.5, 2, 4});
  const radiation::SourceField field(radiation::fit_equivalent_sources(modes));
  std::vector<modal::Listener> all;
  for (const double distance : {0.07, 0.3, 20.0, 3000.0}) {
    for (const Vec3& way : {Vec3(0, 0, 1), Vec3(0.6, 0, 0.8), Vec3(-0.48, 0.6, -0.64)}) {
      all.push_back({distance * way});
    }
  }
  const radiation::ModalPressure together = field.pressure_at(all);
  for (std::size_t row = 0; row < all.size(); ++row) {
    const radiation::ModalPressure alone = field.pressure_at(std::span(all).subspan(row, 1));
    const auto r = static_cast<Eigen::Index>(row);
    EXPECT_EQ(alone.pressure.row(0), together.pressure.row(r));
    EXPECT_EQ(alone.delays[0], together.delays[row]);
    for (std::size_t mode = 0; mode < modes.size(); ++mode) {
      const double k = std::sqrt(modes.eigenvalues[mode]) / modal::speed_of_sound;
      const Complex expected = undelayed(sphere_pressure(1, k, fixed_radius, all[row].position), k,
                                         all[row].position.norm());
      const Complex found = together.pressure(r, static_cast<Eigen::Index>(mode));
      EXPECT_LT(std::abs(found / expected - 1.0), 0.05) << row << ' ' << mode;
    }
  }
}

}  // namespace
}  // namespace carillon::synth
