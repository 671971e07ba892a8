// Bands with thousands of modes, and with none.
#include <gtest/gtest.h>

#include "../solvers/closed_forms.hpp"
#include "../solvers/test_meshes.hpp"
#include "hard_case.hpp"

namespace carillon {
namespace {

using namespace solvers;
using namespace test;

/// Two thousand modes at once, half of all that the elements have: complete by inertia, each with
/// its residual, and a part of them the same as a search for that part alone.
TEST(Hard, TwoThousandModes) {
  const auto block = box_mesh({0.1, 0.1, 0.02}, {10, 10, 1}, 2);
  core::Trace trace;
  solvers::eigen::SolveOptions options;
  options.band = {20, 450000, 3000};
  const auto modes =
      solvers::eigen::solve_modes(block, std::vector{steel}, options, MPI_COMM_SELF, trace);
  expect_sound(modes);
  expect_complete(modes);
  EXPECT_LE(modes.certificate.unknowns, 20000);
  EXPECT_GE(modes.size(), 2000u);
  const solvers::modes::Band part{20, 120000, 300};
  const auto cut = solvers::modes::restrict_to(modes, part), alone = modes_in(block, {steel}, part);
  expect_complete(alone);
  ASSERT_EQ(cut.size(), alone.size());
  ASSERT_GT(alone.size(), 100u);
  EXPECT_LT(worst_cents(frequencies(cut), frequencies(alone), alone.size()), 1e-6);
}

/// A band that holds every mode the elements have, of which the lowest 40 are asked for: all are
/// counted, and the set says how far it reaches.
TEST(Hard, ThousandsOfModesAndFortyWanted) {
  const auto mesh = box_mesh({0.1, 0.1, 0.01}, {8, 8, 1}, 2);
  const auto modes = modes_in(mesh, {glass}, {20, 1e7, 40});
  expect_sound(modes);
  EXPECT_EQ(modes.size(), 40u);
  EXPECT_EQ(modes.certificate.modes_in_band, modes.certificate.unknowns - 6);
  EXPECT_GT(modes.certificate.modes_in_band, 2000);
  EXPECT_FALSE(modes.certificate.complete);
  EXPECT_GE(modes.certificate.complete_to_hz, modes.frequency(39));
}

/// Nothing is audible of a micrometre: an honest empty set, though the band's top lies ten orders
/// of eigenvalue below the first mode.
TEST(Hard, NothingAudibleOfAMicrometre) {
  const auto modes =
      modes_in(box_mesh({0.4e-6, 0.6e-6, 1e-6}, {2, 3, 4}, 2), {steel}, {20, 20000, 300});
  EXPECT_EQ(modes.size(), 0u);
  expect_sound(modes);
  expect_complete(modes);
  EXPECT_EQ(modes.certificate.rigid_modes, 6);
}

/// None between two neighbouring modes: counted at both ends.
TEST(Hard, NoModeInANarrowBand) {
  const auto block = box_mesh({0.02, 0.03, 0.05}, {2, 3, 4}, 2);
  const auto all = frequencies(modes_in(block, {steel}, {20, 60000, 300}));
  ASSERT_GE(all.size(), 6u);
  for (std::size_t k = 0; k + 1 < 6; ++k) {
    const double low = all[k] * (1 + 1e-6), high = all[k + 1] * (1 - 1e-6);
    const auto none = modes_in(block, {steel}, {low, high, 300});
    EXPECT_EQ(none.size(), 0u);
    expect_complete(none);
    EXPECT_EQ(modes_in(block, {steel}, {all[k] * (1 - 1e-6), high, 300}).size(), 1u);
  }
}

}  // namespace
}  // namespace carillon
