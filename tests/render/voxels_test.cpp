#include "render/voxels.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "render/detail/inside_cells.hpp"
#include "render/detail/triangle_box.hpp"
#include "tests/render/bodies.hpp"

namespace carillon::render {
namespace {

constexpr double pi = std::numbers::pi;

long filled(const VoxelGrid& grid) {
  return std::accumulate(grid.cells.begin(), grid.cells.end(), 0L);
}

std::uint8_t at(const VoxelGrid& grid, int x, int y, int z) {
  const int n = grid.resolution;
  return grid.cells[std::size_t((x * n + y) * n + z)];
}

VoxelGrid voxels_of(const solvers::mesh::SurfaceMesh& mesh, VoxelFill fill, int resolution = 30,
                    double pitch = 0) {
  return voxelize(mesh, {resolution, fill, pitch});
}

TEST(TriangleBox, KnowsTheHardCases) {
  const Vec3 centre(0, 0, 0), half(1, 1, 1);
  const auto meets = [&](Vec3 a, Vec3 b, Vec3 c) {
    return triangle_meets_box({a, b, c}, centre, half, 0);
  };
  // A large plane through the middle; a corner cut off; just past the corner.
  EXPECT_TRUE(meets({-9, -9, 0}, {9, -9, 0}, {0, 9, 0}));
  EXPECT_TRUE(meets({2.9, 0, 0}, {0, 2.9, 0}, {0, 0, 2.9}));
  EXPECT_FALSE(meets({3.1, 0, 0}, {0, 3.1, 0}, {0, 0, 3.1}));
  // Boxes of the triangle and of the cell overlap, the triangle passes by an edge.
  EXPECT_FALSE(meets({2.2, 0, 0}, {0, 2.2, 0}, {3, 3, 0}));
  EXPECT_TRUE(meets({1.9, 0, 0}, {0, 1.9, 0}, {3, 3, 0}));
  // Inside, touching, without area.
  EXPECT_TRUE(meets({0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}));
  EXPECT_TRUE(meets({1, 0, 0}, {2, 1, 0}, {2, 0, 1}));
  EXPECT_TRUE(meets({-5, 0, 0}, {5, 0, 0}, {0, 0, 0}));
  EXPECT_FALSE(meets({-5, 2, 0}, {5, 2, 0}, {0, 2, 0}));
}

// Against points strewn over the triangle: one in the box means they meet; and when they do not
// meet by a margin, none is in it.
TEST(TriangleBox, AgreesWithPointsOfTheTriangle) {
  EXPECT_TRUE(rc::check("strewn points", [] {
    const auto coordinate = [] { return *rc::gen::inRange(-250, 251) * 0.01; };
    std::array<Vec3, 3> triangle;
    for (Vec3& corner : triangle) {
      const double x = coordinate(), y = coordinate(), z = coordinate();
      corner = {x, y, z};
    }
    const Vec3 half(1, 0.7, 0.4);
    bool point_inside = false;
    constexpr int steps = 40;
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; i + j <= steps; ++j) {
        const Vec3 p = (triangle[0] * i + triangle[1] * j + triangle[2] * (steps - i - j)) / steps;
        point_inside |= (p.cwiseAbs() - half).maxCoeff() <= 0;
      }
    }
    const bool meets = triangle_meets_box(triangle, Vec3::Zero(), half, 0);
    if (point_inside) RC_ASSERT(meets);
    // A box larger by the strewn points' spacing would catch one of them.
    if (meets) {
      const Vec3 larger = half + Vec3::Constant(0.2);
      bool near = false;
      for (int i = 0; i <= steps; ++i) {
        for (int j = 0; i + j <= steps; ++j) {
          const Vec3 p =
              (triangle[0] * i + triangle[1] * j + triangle[2] * (steps - i - j)) / steps;
          near |= (p.cwiseAbs() - larger).maxCoeff() <= 0;
        }
      }
      RC_ASSERT(near);
    }
  }));
}

TEST(Voxels, FillTheGridWithTheLongestSide) {
  const VoxelGrid grid = voxels_of(box({1, 2, 3}, {1.30, 2.12, 3.06}), VoxelFill::solid);
  EXPECT_EQ(grid.resolution, 30);
  EXPECT_NEAR(grid.pitch, 0.01, 1e-15);
  EXPECT_NEAR((grid.origin - Vec3(1, 2.06 - 0.15, 3.03 - 0.15)).norm(), 0, 1e-12);
  // 30 x 12 x 6 cells exactly: faces between two cells count for the inner one.
  EXPECT_EQ(filled(grid), 30 * 12 * 6);
  EXPECT_EQ(at(grid, 0, 9, 12), 1);
  EXPECT_EQ(at(grid, 0, 8, 12), 0);
  EXPECT_EQ(at(grid, 29, 20, 17), 1);
  EXPECT_EQ(at(grid, 29, 20, 18), 0);
}

TEST(Voxels, SurfaceOfABoxIsItsShell) {
  const auto cube = box({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(filled(voxels_of(cube, VoxelFill::surface)), 30 * 30 * 30 - 28 * 28 * 28);
  EXPECT_EQ(filled(voxels_of(cube, VoxelFill::outer)), 27000);
  EXPECT_EQ(filled(voxels_of(cube, VoxelFill::solid)), 27000);
  EXPECT_EQ(filled(voxels_of(cube, VoxelFill::solid, 1)), 1);
}

TEST(Voxels, SphereVolumeConverges) {
  const auto ball = sphere(0.05, 128);
  double last = 1;
  for (const int n : {10, 20, 40, 80}) {
    const VoxelGrid solid = voxels_of(ball, VoxelFill::solid, n);
    const double error = double(filled(solid)) / (double(n) * n * n) / (pi / 6) - 1;
    // The surface's cells belong to the body: more than its volume, less the finer the grid.
    EXPECT_GT(error, 0) << n;
    EXPECT_LT(error, 0.6 * last) << n;
    EXPECT_EQ(solid.cells, voxels_of(ball, VoxelFill::outer, n).cells) << n;
    last = error;
  }
  EXPECT_LT(last, 0.06);
}

TEST(Voxels, CentresInsideGiveTheVolumeItself) {
  auto ball = sphere(10, 96);
  transform(ball, Eigen::Matrix3d::Identity(), Vec3::Constant(10.5));
  const auto inside = cells_inside(ball.vertices, ball.triangles, 21);
  // The polyhedron has its corners on the sphere: compare with its own volume.
  EXPECT_NEAR(double(std::accumulate(inside.begin(), inside.end(), 0L)) /
                  solvers::mesh::signed_volume(ball),
              1, 0.02);
}

// Rays through the poles, along edges and through vertices of a symmetric body.
TEST(Voxels, RaysThroughEdgesAndCornersCountOnce) {
  solvers::mesh::SurfaceMesh octahedron;
  octahedron.vertices = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                          {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (Vec3& v : octahedron.vertices) v = v * 7.5 + Vec3::Constant(7.5);
  const auto inside = cells_inside(octahedron.vertices, octahedron.triangles, 15);
  for (int x = 0; x < 15; ++x) {
    for (int y = 0; y < 15; ++y) {
      for (int z = 0; z < 15; ++z) {
        const int norm = std::abs(x - 7) + std::abs(y - 7) + std::abs(z - 7);
        if (norm == 7) {
          continue;  // 7 < 7.5: inside, asserted below
        }
        EXPECT_EQ(inside[std::size_t((x * 15 + y) * 15 + z)], norm <= 7 ? 1 : 0)
            << x << " " << y << " " << z;
      }
    }
  }
  EXPECT_EQ(inside[std::size_t((14 * 15 + 7) * 15 + 7)], 1);
  EXPECT_EQ(inside[std::size_t((7 * 15 + 7) * 15 + 0)], 1);
}

TEST(Voxels, HollowSphereIsFilledForSightOnly) {
  auto shell = sphere(1);
  append(shell, sphere(0.6), true);
  const VoxelGrid outer = voxels_of(shell, VoxelFill::outer);
  const VoxelGrid solid = voxels_of(shell, VoxelFill::solid);
  const VoxelGrid surface = voxels_of(shell, VoxelFill::surface);
  EXPECT_EQ(at(outer, 15, 15, 15), 1);
  EXPECT_EQ(at(solid, 15, 15, 15), 0);
  EXPECT_EQ(at(solid, 15, 15, 27), 1);  // between r = 0.6 and 1
  EXPECT_EQ(at(surface, 15, 15, 27), 0);
  EXPECT_EQ(outer.cells, voxels_of(sphere(1), VoxelFill::outer).cells);
  for (std::size_t i = 0; i < solid.cells.size(); ++i) {
    EXPECT_LE(surface.cells[i], solid.cells[i]);
    EXPECT_LE(solid.cells[i], outer.cells[i]);
  }
}

TEST(Voxels, BowlStaysOpen) {
  const VoxelGrid outer = voxels_of(bowl(1, 0.1), VoxelFill::outer);
  const int middle = 15;
  EXPECT_EQ(at(outer, middle, middle, 20), 0);  // the hollow, below the rim
  EXPECT_EQ(at(outer, middle, middle, 7), 1);   // the bottom (the body spans z = 7.5 to 22.5)
  EXPECT_EQ(at(outer, 1, middle, 20), 1);       // the wall
  EXPECT_EQ(outer.cells, voxels_of(bowl(1, 0.1), VoxelFill::solid).cells);
}

TEST(Voxels, QuarterTurnsPermuteCells) {
  // Nothing here is symmetric or lies on cell borders.
  auto body = box({0, 0, 0}, {1, 0.43, 0.31});
  append(body, sphere(0.17, 24), false);
  Eigen::Matrix3d skew = Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  transform(body, skew, Vec3(0.1, 0.2, 0.3));
  Eigen::Matrix3d quarter;
  quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  auto turned = body;
  transform(turned, quarter, Vec3(4, 5, 6));
  for (const VoxelFill fill : {VoxelFill::surface, VoxelFill::outer, VoxelFill::solid}) {
    const VoxelGrid a = voxels_of(body, fill), b = voxels_of(turned, fill);
    int different = 0;
    for (int x = 0; x < 30; ++x) {
      for (int y = 0; y < 30; ++y) {
        for (int z = 0; z < 30; ++z) different += at(a, x, y, z) != at(b, 29 - y, x, z);
      }
    }
    EXPECT_EQ(different, 0);
  }
}

TEST(Voxels, TurnedCopiesStandUprightInCellsOfOneSize) {
  auto body = box({0, 0, 0}, {1, 0.43, 0.31});
  append(body, sphere(0.17, 24), false);
  const Eigen::Matrix3d skew =
      Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  transform(body, skew, Vec3(0.1, 0.2, 0.3));
  const std::vector<VoxelGrid> grids =
      voxelize_turned(body, {.resolution = 30, .fill = VoxelFill::outer, .turns = 12});
  ASSERT_EQ(grids.size(), 12U);
  const double volume = static_cast<double>(filled(grids.front()));
  long longest = 0;
  for (std::size_t k = 0; k < 12; ++k) {
    EXPECT_EQ(grids[k].pitch, grids.front().pitch);
    EXPECT_NEAR(static_cast<double>(filled(grids[k])), volume, 0.1 * volume) << k;
    // A quarter turn later the same cells, permuted.
    const VoxelGrid& later = grids[(k + 3) % 12];
    int different = 0;
    for (int x = 0; x < 30; ++x) {
      for (int y = 0; y < 30; ++y) {
        for (int z = 0; z < 30; ++z) {
          different += at(grids[k], x, y, z) != at(later, 29 - y, x, z);
          if (at(grids[k], x, y, z) != 0) longest = std::max<long>(longest, x);
        }
      }
    }
    EXPECT_LE(different, 4) << k;  // where rounding puts a face into the next cell
  }
  EXPECT_EQ(longest, 29);  // some copy fills the grid
  EXPECT_NE(grids[0].cells, grids[1].cells);
  EXPECT_EQ(voxelize_turned(body, {.turns = 1}).front().cells,
            voxels_of(body, VoxelFill::outer).cells);
  EXPECT_THROW(voxelize_turned(body, {.turns = 0}), core::InputError);
}

TEST(Voxels, QuarterTurnsPermuteCellsOfAlignedBodies) {
  // Every face lies between two cells.
  const VoxelGrid a = voxels_of(box({0, 0, 0}, {0.30, 0.12, 0.06}), VoxelFill::outer);
  const VoxelGrid b = voxels_of(box({0, 0, 0}, {0.12, 0.06, 0.30}), VoxelFill::outer);
  EXPECT_EQ(filled(a), 30 * 12 * 6);
  EXPECT_EQ(filled(b), 30 * 12 * 6);
}

TEST(Voxels, MetricPitchKeepsSize) {
  const auto small = box({0, 0, 0}, {0.1, 0.1, 0.1});
  const VoxelGrid grid = voxels_of(small, VoxelFill::solid, 30, 0.01);
  EXPECT_EQ(grid.pitch, 0.01);
  EXPECT_EQ(filled(grid), 1000);
  EXPECT_NEAR((grid.origin - Vec3::Constant(0.05 - 0.15)).norm(), 0, 1e-15);
  EXPECT_EQ(filled(voxels_of(small, VoxelFill::solid, 30, 0.1 / 30)), 27000);
  try {
    voxels_of(box({0, 0, 0}, {1, 0.5, 0.5}), VoxelFill::solid, 30, 0.01);
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("0.03334"), std::string::npos) << error.what();
  }
}

// A flat sheet has cells wherever it passes, whatever the normal's side.
TEST(Voxels, SheetsAreOneCellThick) {
  solvers::mesh::SurfaceMesh sheet;
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (const VoxelFill fill : {VoxelFill::surface, VoxelFill::outer}) {
    EXPECT_EQ(filled(voxels_of(sheet, fill)), 900);
    EXPECT_EQ(filled(voxels_of(sheet, fill, 31)), 31 * 31);
  }
}

TEST(Voxels, FarFromTheOriginNothingChanges) {
  auto body = bowl(0.05, 0.004);
  const VoxelGrid here = voxels_of(body, VoxelFill::outer, 31);
  transform(body, Eigen::Matrix3d::Identity(), Vec3(100, -200, 50));
  int different = 0;
  const VoxelGrid there = voxels_of(body, VoxelFill::outer, 31);
  for (std::size_t i = 0; i < here.cells.size(); ++i) different += here.cells[i] != there.cells[i];
  EXPECT_LE(different, 2);
}

TEST(Voxels, RefuseWhatCannotBe) {
  const auto cube = box({0, 0, 0}, {1, 1, 1});
  EXPECT_THROW(voxels_of({}, VoxelFill::outer), core::InputError);
  EXPECT_THROW(voxels_of(cube, VoxelFill::outer, 0), core::InputError);
  EXPECT_THROW(voxels_of(cube, VoxelFill::outer, 100000), core::InputError);
  EXPECT_THROW(voxels_of(cube, VoxelFill::outer, 30, -1), core::InputError);
  auto broken = cube;
  broken.vertices[3].x() = std::nan("");
  EXPECT_THROW(voxels_of(broken, VoxelFill::outer), core::InputError);
  broken = cube;
  broken.triangles[0][1] = 8;
  EXPECT_THROW(voxels_of(broken, VoxelFill::outer), core::InputError);
  solvers::mesh::SurfaceMesh point;
  point.vertices = {{1, 1, 1}};
  point.triangles = {{0, 0, 0}};
  EXPECT_THROW(voxels_of(point, VoxelFill::outer), core::InputError);
}

TEST(VoxelFills, AreNamed) {
  EXPECT_EQ(parse_voxel_fill("surface"), VoxelFill::surface);
  EXPECT_EQ(parse_voxel_fill("outer"), VoxelFill::outer);
  EXPECT_EQ(parse_voxel_fill("solid"), VoxelFill::solid);
  try {
    parse_voxel_fill("sold");
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("solid"), std::string::npos);
  }
}

}  // namespace
}  // namespace carillon::render
