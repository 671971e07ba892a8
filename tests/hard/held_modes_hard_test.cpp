// What springs hold, against closed forms and against the exact coupled problem: all modes of a
// mesh are a complete basis, in which the springs leave nothing out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "../solvers/test_meshes.hpp"
#include "core/error.hpp"
#include "hard_case.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/support/held_modes.hpp"
#include "synth/support/support_contacts.hpp"
#include "synth/support/supports.hpp"

namespace carillon {
namespace {

using namespace test;
using synth::support::Contact;
using synth::support::contact_factor;

constexpr double pi = std::numbers::pi;
const solvers::elements::Elastic steel{2e11, 0.29, 7850};

double omega_of(const solvers::modes::Modes& modes, std::size_t mode) {
  return std::sqrt(modes.eigenvalues[mode]);
}

/// Contacts all with one spring [N/m] each, shear included.
synth::support::HeldModes held_by(const solvers::modes::Modes& modes,
                                  const std::vector<std::vector<Contact>>& places, double stiffness,
                                  double shear) {
  const synth::surface::RigidBody rigid = synth::surface::rigid_body(modes);
  Eigen::MatrixXd springs(static_cast<Eigen::Index>(modes.size()) + 6, 0);
  for (const std::vector<Contact>& contacts : places) {
    const Eigen::MatrixXd factor = contact_factor(modes, contacts, shear, &rigid);
    springs.conservativeResize(Eigen::NoChange, springs.cols() + factor.cols());
    springs.rightCols(factor.cols()) = std::sqrt(stiffness) * factor;
  }
  return synth::support::hold_modes(modes, std::vector<double>(modes.size(), 2.0), rigid, springs);
}

/// The lowest `count` of a mesh's modes, as a band cut there would have them.
solvers::modes::Modes lowest(const solvers::modes::Modes& modes, int count) {
  solvers::modes::Band band{modes.certificate.min_frequency, modes.certificate.max_frequency,
                            count};
  return restrict_to(modes, band);
}

// Winkler's bed under the whole of a thin plate moves every bending mode alike: omega^2 grows by
// stiffness per area over mass per area, from nothing for the three motions as a whole.
TEST(HeldModesHard, APlateOnFoam) {
  const double thickness = 0.002, bed = 2e6;
  const auto modes =
      modes_in(box_mesh({0.2, 0.15, thickness}, {6, 5, 1}, 3), {steel}, {5, 3000, 60});
  const std::vector<Contact> under =
      synth::support::lowest_contacts(modes.surface, {0, 0, -1}, 1e-4);
  const double area = synth::support::area_of(under);
  EXPECT_NEAR(area, 0.03, 1e-9);
  const synth::support::HeldModes held = held_by(modes, {under}, bed * area, 0);
  const double gain = bed / (steel.density * thickness);
  ASSERT_GE(held.modes.size(), modes.size() + 2);  // one may leave the band upwards
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_NEAR(omega_of(held.modes, j) / std::sqrt(gain), 1, 2e-3) << j;
    EXPECT_NEAR(held.decay_rates[j], 0, 0.01) << j;
  }
  for (std::size_t j = 0; j < 12; ++j) {
    const double expected = std::sqrt(modes.eigenvalues[j] + gain);
    EXPECT_NEAR(omega_of(held.modes, j + 3) / expected, 1, 2e-3) << j;
    EXPECT_NEAR(held.decay_rates[j + 3], 2, 0.02) << j;
  }
  // The three as a whole share their motion, and their shapes at a node add up to what the six
  // have.
  const Eigen::Matrix3d at = held.modes.shapes.at(0).topRows<3>();
  const synth::surface::RigidBody rigid = synth::surface::rigid_body(modes);
  const auto all = synth::surface::rigid_shapes_at(rigid, modes.surface.nodes.front());
  EXPECT_NEAR(at.col(2).squaredNorm() / all.col(2).squaredNorm(), 1, 0.01);
}

// Soft springs under a stiff body: three of its six motions as a whole are those of a mass on them.
TEST(HeldModesHard, ABlockOnThreeSoftFeet) {
  const auto modes = modes_in(box_mesh({0.06, 0.06, 0.04}, {2, 2, 2}, 2), {steel}, {5, 60000, 20});
  const synth::modal::SurfaceSampler sampler(modes.surface);
  std::vector<std::vector<Contact>> feet;
  for (int k = 0; k < 3; ++k) {
    const double angle = 2 * pi * k / 3;
    feet.push_back(synth::support::point_contact(
        modes.surface,
        sampler.nearest({0.03 + 0.02 * std::cos(angle), 0.03 + 0.02 * std::sin(angle), 0})));
  }
  const double stiffness = 1e5;
  const synth::support::HeldModes held = held_by(modes, feet, stiffness, 0);
  std::vector<double> expected = {3 * stiffness / modes.mass};
  const synth::surface::RigidBody rigid = synth::surface::rigid_body(modes);
  for (int k = 0; k < 2; ++k) {  // about two axes across: 3/2 k r^2
    expected.push_back(1.5 * stiffness * 0.02 * 0.02 / rigid.inertia.minCoeff());
  }
  std::sort(expected.begin(), expected.end());
  // The largest moment is that about the upright axis, where nothing holds it.
  ASSERT_GE(held.modes.size(), 3u);
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_NEAR(held.modes.eigenvalues[j] / expected[j], 1, 2e-3) << j;
  }
  EXPECT_EQ(held.modes.certificate.rigid_modes, 3);
}

class ExactlyCoupled : public testing::Test {
 protected:
  void SetUp() override {
    whole = modes_in(box_mesh({0.1, 0.06, 0.004}, {5, 3, 1}, 2), {steel}, {20, 1e8, 100000});
    ASSERT_EQ(static_cast<std::int64_t>(whole.size()) + 6, whole.certificate.unknowns);
    whole.pitch_errors.assign(whole.size(), 0.0);  // the mesh is the truth here
  }

  /// Modes are above the exact ones, and no farther than they say.
  void expect_within(const std::vector<std::vector<Contact>>& places, double stiffness,
                     double shear, std::size_t count, double largest) {
    const auto exact = held_by(whole, places, stiffness, shear);
    for (const int basis : {40, 80, 160}) {
      const auto held = held_by(lowest(whole, basis), places, stiffness, shear);
      double worst = 0;
      for (std::size_t j = 0; j < count; ++j) {
        const double cents = 1200 * std::log2(held.modes.frequency(j) / exact.modes.frequency(j));
        EXPECT_GE(cents, -1e-6) << j << " of " << basis;
        EXPECT_LE(cents, held.modes.pitch_errors[j] + 0.01) << j << " of " << basis;
        worst = std::max(worst, cents);
      }
      std::printf(
          "%d modes: worst of %zu %.2f cents, said %.2f\n", basis, count, worst,
          *std::max_element(held.modes.pitch_errors.begin(),
                            held.modes.pitch_errors.begin() + static_cast<std::ptrdiff_t>(count)));
      if (basis == 160) EXPECT_LT(worst, largest);
    }
  }

  solvers::modes::Modes whole;
};

TEST_F(ExactlyCoupled, APlateOnThreePoints) {
  const synth::modal::SurfaceSampler sampler(whole.surface);
  std::vector<std::vector<Contact>> points;
  for (const Vec3& at : {Vec3(0.02, 0.01, 0), Vec3(0.02, 0.05, 0), Vec3(0.08, 0.03, 0)}) {
    points.push_back(synth::support::point_contact(whole.surface, sampler.nearest(at)));
  }
  expect_within(points, 1e6, 0.8, 8, 10);
}

TEST_F(ExactlyCoupled, APlateClampedAtAnEdge) {
  std::vector<Contact> edge;
  for (const Contact& contact : synth::support::lowest_contacts(whole.surface, {-1, 0, 0}, 1e-4)) {
    edge.push_back(contact);
  }
  expect_within({edge}, 1e8, 0.8, 8, 60);
}

// A slender bar whose end is held stiffly: Euler and Bernoulli's cantilever.
TEST(HeldModesHard, ABarHeldAtItsEndIsACantilever) {
  const double length = 0.2, height = 0.004;
  const auto modes =
      modes_in(box_mesh({length, 0.006, height}, {16, 1, 1}, 3), {steel}, {5, 400000, 120});
  const auto end = synth::support::lowest_contacts(modes.surface, {-1, 0, 0}, 1e-4);
  const double c = std::sqrt(steel.youngs_modulus / (12 * steel.density)) * height;
  const double first = 1.8751 * 1.8751 / (2 * pi) * c / (length * length);
  double before = 1e9;
  for (const int basis : {30, 60, 120}) {
    const synth::support::HeldModes held = held_by(lowest(modes, basis), {end}, 1e10, 0.8);
    // Across its thin side, then across the wide one: each above the truth by no more than it says.
    for (const std::size_t j : {0u, 1u}) {
      const double expected = j == 0 ? first : 1.5 * first;
      const double cents = 1200 * std::log2(held.modes.frequency(j) / expected);
      std::printf("%d modes, %zu: %.1f cents above the beam, said %.1f\n", basis, j, cents,
                  held.modes.pitch_errors[j]);
      EXPECT_GE(cents, -3);
      EXPECT_LE(cents, held.modes.pitch_errors[j] + 10);
    }
    EXPECT_LT(held.modes.frequency(0), before);
    before = held.modes.frequency(0);
  }
}

TEST(HeldModesHard, NothingHoldsAndEverythingHolds) {
  const auto modes = modes_in(box_mesh({0.1, 0.06, 0.004}, {3, 2, 1}, 2), {steel}, {20, 40000, 20});
  const auto under = synth::support::lowest_contacts(modes.surface, {0, 0, -1}, 1e-4);
  const auto free = held_by(modes, {under}, 0, 0.8);
  ASSERT_EQ(free.modes.size(), modes.size());
  for (std::size_t j = 0; j < modes.size(); ++j) {
    EXPECT_NEAR(free.modes.eigenvalues[j] / modes.eigenvalues[j], 1, 1e-12);
  }
  // Far above what the modes can tell from rigid: finite, and nothing is below the free ones.
  const auto stiff = held_by(modes, {under}, 1e16, 0.8);
  for (const double lambda : stiff.modes.eigenvalues) {
    EXPECT_TRUE(std::isfinite(lambda));
    EXPECT_LE(lambda, modes.eigenvalues.back() * 1.0001);
  }
  const synth::surface::RigidBody rigid = synth::surface::rigid_body(modes);
  EXPECT_THROW(synth::support::hold_modes(modes, std::vector<double>(modes.size(), 0.0), rigid,
                                          Eigen::MatrixXd::Zero(3, 1)),
               core::InputError);
  Eigen::MatrixXd broken = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(modes.size()) + 6, 1);
  broken(0, 0) = std::nan("");
  EXPECT_THROW(
      synth::support::hold_modes(modes, std::vector<double>(modes.size(), 0.0), rigid, broken),
      core::InputError);
}

}  // namespace
}  // namespace carillon
