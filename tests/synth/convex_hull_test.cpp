// Hulls of bodies and of their pieces.
#include "synth/motion/convex_hull.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/solvers/test_meshes.hpp"

namespace carillon::synth {
namespace {

double volume_of(const std::vector<std::vector<Vec3>>& pieces) {
  double sum = 0;
  for (const auto& piece : pieces) sum += solvers::mesh::signed_volume(motion::convex_hull(piece));
  return sum;
}

TEST(ConvexHull, OfABoxFarFromTheOrigin) {
  std::vector<Vec3> points;
  for (int k = 0; k < 27; ++k) {
    points.emplace_back(100 + 0.01 * (k % 3), -50 + 0.02 * (k / 3 % 3), 0.005 * (k / 9));
  }
  const solvers::mesh::SurfaceMesh hull = motion::convex_hull(points);
  EXPECT_EQ(hull.vertices.size(), 8u);
  EXPECT_EQ(hull.triangles.size(), 12u);
  EXPECT_NEAR(solvers::mesh::signed_volume(hull), 0.02 * 0.04 * 0.01, 1e-14);
}

TEST(ConvexHull, WithoutVolumeIsEmpty) {
  EXPECT_TRUE(motion::convex_hull({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}).triangles.empty());
  EXPECT_TRUE(motion::convex_hull(std::vector<Vec3>(10, Vec3(1, 2, 3))).triangles.empty());
}

TEST(ConvexPieces, AConvexBodyIsOne) {
  const auto pieces = motion::convex_pieces(test::box_mesh({0.1, 0.2, 0.3}, {2, 3, 4}, 2));
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].size(), 8u);
  EXPECT_EQ(motion::convex_pieces(test::ball_mesh(0.1, 3, 2)).size(), 1u);
}

// The hull of a hollow ball is a full one; its pieces are a wall.
TEST(ConvexPieces, AHollowBallIsManyThatLeaveItHollow) {
  const solvers::mesh::TetMesh shell = test::shell_mesh(0.05, 0.045, 4, 1, 2);
  const auto pieces = motion::convex_pieces(shell, 0.3, 512);
  const double volume = 4.0 / 3 * std::numbers::pi * (std::pow(0.05, 3) - std::pow(0.045, 3));
  EXPECT_GT(pieces.size(), 8u);
  EXPECT_GE(volume_of(pieces), 0.98 * volume);
  EXPECT_LE(volume_of(pieces), 1.5 * volume);
  for (const auto& piece : pieces) {
    for (const Vec3& p : piece) EXPECT_GT(p.norm(), 0.0449);
  }
  // The fewer pieces, the more they hold beside the wall.
  const double few = volume_of(motion::convex_pieces(shell, 0.3, 64));
  EXPECT_GT(few, volume_of(pieces));
  EXPECT_LT(few, 2 * volume);
}

TEST(ConvexPieces, AnLIsTwoOrMore) {
  solvers::mesh::TetMesh mesh = test::joined(test::box_mesh({0.1, 0.02, 0.02}, {10, 2, 2}, 1),
                                             test::box_mesh({0.02, 0.1, 0.02}, {2, 10, 2}, 1));
  const auto pieces = motion::convex_pieces(mesh, 0.05);
  EXPECT_GE(pieces.size(), 2u);
}

}  // namespace
}  // namespace carillon::synth
