#include "synth/modal/ring_down.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "tests/synth/curved_bodies.hpp"

namespace carillon::synth {
namespace {

constexpr double pi = std::numbers::pi;

/// Smooth, unlike fields, as good as any modes for what is tested here.
Vec3 wavy(int mode, const Vec3& x) {
  return {std::sin(3 * x.x() + mode), std::cos(2 * x.y() * (mode + 1)),
          std::sin(x.z() + 0.5 * mode * x.x())};
}

solvers::modes::Modes wavy_modes(int count) {
  std::vector<double> eigenvalues;
  for (int i = 0; i < count; ++i) eigenvalues.push_back(std::pow(2 * pi * 200 * (i + 1), 2));
  return modes_with(curved_sphere(0.1, Vec3::Zero(), 2, 3), eigenvalues, wavy);
}

modal::Strike inward_strike(const solvers::modes::Modes& modes, const modal::SurfacePoint& point) {
  return {point, -modal::frame_at(modes.surface, point).normal, 0.02, 1e-3};
}

const modal::SurfacePoint somewhere{5, {0.2, 0.3, 0.5}};

TEST(ShapesAt, InterpolatesWithTheNodesOfTheFace) {
  // A linear field is met exactly by every order.
  Eigen::Matrix3d gradient;
  gradient << 1, 2, 3, -1, 0.5, 2, 4, -2, 1;
  for (int order = 1; order <= 4; ++order) {
    const auto modes = modes_with(curved_sphere(0.1, Vec3(1, 2, 3), 2, order), {1e6},
                                  [&](int, const Vec3& x) -> Vec3 { return gradient * x; });
    const Vec3 position = modal::frame_at(modes.surface, somewhere).position;
    const Eigen::MatrixX3d shapes = modal::shapes_at(modes, somewhere);
    ASSERT_EQ(shapes.rows(), 1);
    EXPECT_LT((shapes.row(0).transpose() - gradient * position).norm(), 1e-5) << order;
  }
}

TEST(DecayRates, WeighsRegionsByTheirShareOfEnergy) {
  solvers::modes::Modes modes = wavy_modes(2);
  modes.kinetic_fraction.resize(2, 2);
  modes.strain_fraction.resize(2, 2);
  modes.kinetic_fraction << 0.25, 0.75, 1, 0;
  modes.strain_fraction << 0.9, 0.1, 0, 1;
  const std::vector<damping::DampingModel> regions = {damping::rayleigh_damping(4, 1e-7),
                                                      damping::rayleigh_damping(40, 3e-6)};
  const auto d = damping::decay_rates(modes, regions);
  const double lambda0 = modes.eigenvalues[0], lambda1 = modes.eigenvalues[1];
  EXPECT_NEAR(2 * d[0], 4 * 0.25 + 40 * 0.75 + lambda0 * (0.9e-7 + 0.3e-6), 1e-12 * lambda0);
  EXPECT_NEAR(2 * d[1], 4 + lambda1 * 3e-6, 1e-9);
  EXPECT_THROW(damping::decay_rates(modes, std::vector{damping::rayleigh_damping(1, 0)}),
               core::InputError);
  EXPECT_THROW(damping::decay_rates(modes, std::vector{damping::rayleigh_damping(1, 0),
                                                       damping::rayleigh_damping(-1, 0)}),
               core::InputError);
}

TEST(DecayRates, OfOneRegionAreRayleighs) {
  const solvers::modes::Modes modes = wavy_modes(5);
  const damping::DampingModel steel = damping::rayleigh_damping(5, 3e-8);
  const auto d = damping::decay_rates(modes, std::span(&steel, 1));
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(modal::t60(d[i]) * (5 + 3e-8 * modes.eigenvalues[i]) / 2, std::log(1000.0), 1e-12);
  }
}

/// Struck and heard: the dry signal without listeners, else the monopole's pressure.
modal::RingDown rings_of(const solvers::modes::Modes& modes, std::span<const double> d,
                         const modal::Strike& strike, std::span<const modal::Listener> listeners) {
  return modal::ring_down(modes, d, strike,
                          listeners.empty() ? modal::point_velocity(modes, strike.point)
                                            : modal::monopole(modes, listeners));
}

/// What each mode contributes per row; velocities of dry signals, accelerations of monopoles.
Eigen::MatrixXd gains(const modal::RingDown& rings) {
  const modal::Readout& readout = rings.readout;
  return (readout.unit == "Pa" ? readout.acceleration : readout.velocity) *
         rings.excitation.asDiagonal();
}

TEST(RingDown, DryGainIsForceTimesNormalMotion) {
  const solvers::modes::Modes modes = wavy_modes(4);
  const std::vector<double> d(4, 1.0);
  modal::Strike strike = inward_strike(modes, somewhere);
  strike.direction = Vec3(1, -2, 2) / 3;
  const modal::RingDown rings = rings_of(modes, d, strike, {});
  ASSERT_EQ(gains(rings).rows(), 1);
  EXPECT_EQ(rings.readout.unit, "m/s");
  EXPECT_EQ(rings.readout.delays, std::vector<double>{0.0});
  const Eigen::MatrixX3d shapes = modal::shapes_at(modes, somewhere);
  const Vec3 normal = modal::frame_at(modes.surface, somewhere).normal;
  for (Eigen::Index i = 0; i < 4; ++i) {
    const double expected = 0.02 * shapes.row(i).dot(strike.direction) * shapes.row(i).dot(normal);
    EXPECT_NEAR(gains(rings)(0, i), expected, 1e-15);
  }
}

// The body gives no energy: pushed inward, no mode answers outward first.
TEST(RingDown, InwardStrikesMoveThePointInward) {
  const solvers::modes::Modes modes = wavy_modes(6);
  const std::vector<double> d(6, 1.0);
  for (std::int32_t face = 0; face < 32; ++face) {
    const modal::RingDown rings =
        rings_of(modes, d, inward_strike(modes, {face, {0.4, 0.4, 0.2}}), {});
    EXPECT_LE(gains(rings).maxCoeff(), 0);
    EXPECT_LT(modal::synthesize(rings, {0}, 44100, 1)[0], 0);
  }
}

// Neither the sign of a mode nor the basis chosen within a pair of equal frequency may matter.
TEST(RingDown, IgnoresSignsAndBasesOfPairs) {
  EXPECT_TRUE(rc::check("basis", [] {
    solvers::modes::Modes modes = wavy_modes(4);
    modes.eigenvalues[2] = modes.eigenvalues[1];
    const double angle = *rc::gen::inRange(0, 6283) * 1e-3;
    const std::int32_t face = *rc::gen::inRange(0, 32);
    solvers::modes::Modes turned = modes;
    const solvers::modes::ModeShapes::Rows before = modes.shapes.at_nodes();
    solvers::modes::ModeShapes::Rows after = before;
    after.row(0) *= -1;
    after.row(1) = float(std::cos(angle)) * before.row(1) + float(std::sin(angle)) * before.row(2);
    after.row(2) = float(-std::sin(angle)) * before.row(1) + float(std::cos(angle)) * before.row(2);
    turned.shapes = solvers::modes::ModeShapes(after);
    const std::vector<double> d(4, 3.0);
    const modal::Strike strike = inward_strike(modes, {face, {0.1, 0.6, 0.3}});
    const std::vector<modal::Listener> far = {{{1, 0.5, 0.2}}};
    for (const std::span<const modal::Listener> listeners :
         {std::span<const modal::Listener>{}, std::span<const modal::Listener>(far)}) {
      const modal::RingDown a = rings_of(modes, d, strike, listeners);
      const modal::RingDown b = rings_of(turned, d, strike, listeners);
      const double scale = gains(a).cwiseAbs().maxCoeff();
      RC_ASSERT(std::abs(gains(a)(0, 0) - gains(b)(0, 0)) < 1e-5 * scale);
      RC_ASSERT(std::abs(gains(a)(0, 1) + gains(a)(0, 2) - gains(b)(0, 1) - gains(b)(0, 2)) <
                1e-5 * scale);
      const auto sound_a = modal::synthesize(a, {1e-3}, 44100, 400);
      const auto sound_b = modal::synthesize(b, {1e-3}, 44100, 400);
      double peak = 0, worst = 0;
      for (std::size_t n = 0; n < 400; ++n) {
        peak = std::max(peak, std::abs(double(sound_a[n])));
        worst = std::max(worst, std::abs(double(sound_a[n]) - sound_b[n]));
      }
      RC_ASSERT(worst < 1e-4 * peak);
    }
  }));
}

TEST(RingDown, DoesNotDependOnWhereTheBodyLiesAndHowItIsTurned) {
  const solvers::modes::Modes modes = wavy_modes(3);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  const Vec3 shift(3, -2, 1);
  solvers::modes::Modes moved = modes;
  for (Vec3& node : moved.surface.nodes) node = turn * node + shift;
  moved.shapes = turned_shapes(modes.shapes, turn);
  const std::vector<double> d(3, 2.0);
  const modal::Strike strike = inward_strike(modes, somewhere);
  const modal::Strike moved_strike = inward_strike(moved, somewhere);
  const Vec3 ear(0.7, 0.2, -0.4);
  const std::vector<modal::Listener> here = {{ear}}, there = {{turn * ear + shift}};
  const double dry = gains(rings_of(modes, d, strike, {})).norm();
  EXPECT_LT(
      (gains(rings_of(modes, d, strike, {})) - gains(rings_of(moved, d, moved_strike, {}))).norm(),
      1e-5 * dry);
  const modal::RingDown a = rings_of(modes, d, strike, here);
  const modal::RingDown b = rings_of(moved, d, moved_strike, there);
  EXPECT_LT((gains(a) - gains(b)).norm(), 1e-5 * gains(a).norm());
  EXPECT_NEAR(a.readout.delays[0], b.readout.delays[0], 1e-12);
}

// A breathing sphere is the monopole itself: p = rho R^2 q'' / r, q'' the surface's acceleration,
// after r / c.
TEST(RingDown, BreathingSphereRadiatesAsAMonopole) {
  constexpr double fixed_radius = 0.05, mass = 2.5, omega = 2 * pi * 900, decay_constant = 30;
  const double phi = 1 / std::sqrt(mass);
  const Vec3 centre(0.4, 0, -1);
  const auto modes =
      modes_with(curved_sphere(fixed_radius, centre, 6, 3), {omega * omega},
                 [&](int, const Vec3& x) -> Vec3 { return phi * (x - centre).normalized(); });
  const std::vector<double> d = {decay_constant};
  const modal::Strike strike{
      somewhere, -modal::frame_at(modes.surface, somewhere).normal, 0.3, {0}};
  const std::vector<modal::Listener> listeners = {{centre + Vec3(0, 0.8, 0)},
                                                  {centre + Vec3(3, 0, 4)}};
  const modal::RingDown rings = rings_of(modes, d, strike, listeners);
  EXPECT_EQ(rings.readout.unit, "Pa");
  constexpr std::size_t sample_count = 2000;
  const auto sound = modal::synthesize(rings, {0}, 44100, sample_count);
  const double damped = std::sqrt(omega * omega - decay_constant * decay_constant);
  for (std::size_t row = 0; row < 2; ++row) {
    const double r = row == 0 ? 0.8 : 5.0;
    const double scale = 1.204 * fixed_radius * fixed_radius / r * phi * phi * 0.3;
    for (std::size_t n = 0; n < sample_count; ++n) {
      const double t = double(n) / 44100 - r / 343.0;
      // Acceleration of a unit impulse response, pushed inward.
      const double expected = t < 0 ? 0
                                    : -scale * std::exp(-decay_constant * t) *
                                          (-2 * decay_constant * std::cos(damped * t) +
                                           (decay_constant * decay_constant - damped * damped) /
                                               damped * std::sin(damped * t));
      ASSERT_NEAR(sound[row * sample_count + n], expected, 1e-4 * scale * omega) << row << " " << n;
    }
  }
}

TEST(RingDown, MotionWithoutVolumeVelocityIsSilentInTheMonopole) {
  // A translation, and the sphere's quadrupole.
  const auto modes = modes_with(curved_sphere(0.1, Vec3::Zero(), 4, 3), {1e6, 2e6},
                                [](int mode, const Vec3& x) -> Vec3 {
                                  return mode == 0 ? Vec3(1, 2, 3) : Vec3(x.x(), -x.y(), 0) / 0.1;
                                });
  const std::vector<double> d = {1, 1};
  const std::vector<modal::Listener> listeners = {{{1, 0, 0}}};
  const modal::RingDown rings = rings_of(modes, d, inward_strike(modes, somewhere), listeners);
  // Against the volume velocity that the same motion, directed outward, would have.
  const double breathing = modal::air_density / (4 * pi) * 0.02 * 4 * pi * 0.01;
  EXPECT_LT(std::abs(gains(rings)(0, 0)), 1e-6 * breathing);
  EXPECT_LT(std::abs(gains(rings)(0, 1)), 1e-6 * breathing);
}

TEST(RingDown, CavitiesDoNotRadiate) {
  const auto radial = [](int, const Vec3& x) -> Vec3 { return x.normalized(); };
  solvers::modes::ModeSurface shell = curved_sphere(0.1, Vec3::Zero(), 3, 2);
  const auto solid = modes_with(shell, {1e6}, radial);
  append(shell, curved_sphere(0.08, Vec3::Zero(), 3, 2, true));
  const auto hollow = modes_with(shell, {1e6}, radial);
  const std::vector<double> d = {1};
  const std::vector<modal::Listener> listeners = {{{1, 0, 0}}};
  const modal::Strike strike = inward_strike(solid, somewhere);
  EXPECT_EQ(gains(rings_of(solid, d, strike, listeners))(0, 0),
            gains(rings_of(hollow, d, strike, listeners))(0, 0));
}

TEST(RingDown, FallsWithDistanceAndRefusesListenersInside) {
  const solvers::modes::Modes modes = wavy_modes(2);
  const std::vector<double> d = {1, 1};
  const modal::Strike strike = inward_strike(modes, somewhere);
  const std::vector<modal::Listener> two = {{{1, 0, 0}}, {{0, 0, 4}}};
  const modal::RingDown rings = rings_of(modes, d, strike, two);
  EXPECT_NEAR(gains(rings)(0, 0) / gains(rings)(1, 0), 4, 1e-9);
  EXPECT_NEAR(rings.readout.delays[1], 4 / 343.0, 1e-9);
  for (const double r : {0.0, 0.05, 0.0999}) {
    const std::vector<modal::Listener> near = {{{r, 0, 0}}};
    EXPECT_THROW(rings_of(modes, d, strike, near), core::InputError) << r;
  }
}

TEST(RingDown, RefusesWhatCannotBe) {
  const solvers::modes::Modes modes = wavy_modes(2);
  const std::vector<double> d = {1, 1};
  modal::Strike strike = inward_strike(modes, somewhere);
  EXPECT_THROW(rings_of(modes, std::vector<double>{1}, strike, {}), core::InputError);
  strike.direction *= 2;
  EXPECT_THROW(rings_of(modes, d, strike, {}), core::InputError);
  strike = inward_strike(modes, somewhere);
  strike.point.face = 999;
  EXPECT_THROW(rings_of(modes, d, strike, {}), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
