#include "solvers/modes/mode_shapes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/error.hpp"

namespace carillon {
namespace {

using solvers::modes::CircumferentialWave;
using solvers::modes::ModeShapes;
using solvers::modes::NodeRing;

/// A node on the axis, a ring of seven and one of twelve.
const std::vector<NodeRing> three_rings = {{0, 1}, {1, 7}, {8, 12}};

ModeShapes on_rings(const std::vector<CircumferentialWave>& waves,
                    const std::vector<std::array<float, 9>>& amplitudes) {
  ModeShapes::Rows rows(static_cast<Eigen::Index>(amplitudes.size()), 9);
  for (Eigen::Index mode = 0; mode < rows.rows(); ++mode)
    for (Eigen::Index k = 0; k < 9; ++k)
      rows(mode, k) = amplitudes[static_cast<std::size_t>(mode)][static_cast<std::size_t>(k)];
  return ModeShapes(rows, three_rings, waves);
}

/// Translations along x and y are the two modes of n = 1 with u = 1 and v = -1, those along z and
/// turns about it are n = 0.
TEST(ModeShapes, RigidMotionsOfRingsAreRigidMotions) {
  const std::array<float, 9> across = {1, -1, 0, 1, -1, 0, 1, -1, 0};
  const ModeShapes shapes =
      on_rings({{1, 0}, {1, 1}, {0, 0}, {0, 0}},
               {across, across, {0, 0, 1, 0, 0, 1, 0, 0, 1}, {0, 0, 0, 0, 2, 0, 0, 3, 0}});
  ASSERT_EQ(shapes.nodes(), 20);
  for (Eigen::Index node = 0; node < 20; ++node) {
    const Eigen::MatrixX3d at = shapes.at(node);
    EXPECT_LT((at.row(0) - Eigen::RowVector3d(1, 0, 0)).norm(), 1e-12) << node;
    EXPECT_LT((at.row(1) - Eigen::RowVector3d(0, 1, 0)).norm(), 1e-12) << node;
    EXPECT_LT((at.row(2) - Eigen::RowVector3d(0, 0, 1)).norm(), 1e-12) << node;
    const bool outer = node >= 8;
    const double radius = node == 0 ? 0 : outer ? 3 : 2;
    const double angle =
        2 * std::numbers::pi * static_cast<double>(outer ? node - 8 : node - 1) / (outer ? 12 : 7);
    const Eigen::RowVector3d turn(-radius * std::sin(angle), radius * std::cos(angle), 0);
    EXPECT_LT((at.row(3) - turn).norm(), 1e-12) << node;
  }
}

TEST(ModeShapes, EveryWayOfReadingThemGivesTheSame) {
  ModeShapes shapes = on_rings({{0, 0}, {3, 0}, {3, 1}}, {{0, 0, 1, 2, 3, 4, 5, 6, 7},
                                                          {0, 0, 0, 1, -2, 0.5, 2, 0.25, -1},
                                                          {0, 0, 0, 1, -2, 0.5, 2, 0.25, -1}});
  shapes *= 0.5F;
  const ModeShapes known(shapes.at_nodes());
  EXPECT_EQ(known.nodes(), shapes.nodes());
  EXPECT_TRUE(known.harmonics().empty());
  EXPECT_EQ(shapes.harmonics(), (std::vector<int>{0, 3, 3}));
  for (Eigen::Index mode = 0; mode < 3; ++mode)
    EXPECT_LT((known.of(mode) - shapes.of(mode)).norm(), 1e-6);
  for (Eigen::Index node = 0; node < shapes.nodes(); ++node)
    EXPECT_LT((known.at(node) - shapes.at(node)).norm(), 1e-6) << node;
  const std::vector<Eigen::Index> chosen = {2, 0};
  const ModeShapes some = shapes.select(chosen);
  ASSERT_EQ(some.modes(), 2);
  EXPECT_EQ(some.of(0), shapes.of(2));
  EXPECT_EQ(some.of(1), shapes.of(0));
  EXPECT_EQ(some.harmonics(), (std::vector<int>{3, 0}));
  EXPECT_EQ(known.select(chosen).at_nodes(), some.at_nodes());
  // Squares of a pair add up to the same all the way around.
  for (Eigen::Index part = 0; part < 12; ++part) {
    const Eigen::MatrixX3d at = shapes.at(8 + part);
    EXPECT_NEAR(at.row(1)[2] * at.row(1)[2] + at.row(2)[2] * at.row(2)[2], 0.25, 1e-12);
  }
}

TEST(ModeShapes, RefuseNodesThatAreInNoRing) {
  const ModeShapes::Rows rows = ModeShapes::Rows::Zero(1, 6);
  EXPECT_THROW(ModeShapes(rows, {{0, 4}, {5, 4}}, {{0, 0}}), core::InputError);
  EXPECT_THROW(ModeShapes(rows, {{0, 4}, {4, 0}}, {{0, 0}}), core::InputError);
  EXPECT_THROW(ModeShapes(rows, {{0, 4}}, {{0, 0}}), core::InputError);
  EXPECT_THROW(ModeShapes(rows, {{0, 4}, {4, 4}}, {}), core::InputError);
}

}  // namespace
}  // namespace carillon
