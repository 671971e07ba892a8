#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "core/random.hpp"
#include "solvers/textures/generated_maps.hpp"
#include "solvers/textures/surface_map.hpp"

namespace carillon::solvers {
namespace {

using Eigen::Vector2d;

SurfaceMap random_relief(int width, int height, bool repeats, std::uint64_t seed = 1) {
  core::RandomStream random(seed, 0, "test");
  SurfaceMap map{"random", width, height, 0.1, repeats, {}, {}, {}};
  for (int i = 0; i < width * height; ++i) map.heights.push_back(float(-random.uniform()));
  return map;
}

TEST(TextureSampling, IsTheSplineOfSciPy) {
  struct Row {
    double u, v;
    int repeats;
    double height, du, dv, duu, duv, dvv;
  };
  const Row rows[] = {
#include "textures_spline_reference.inc"
  };
  SurfaceMap map{"reference", 7, 5, 0.25, true, {}, {}, {}};
  for (int j = 0; j < 5; ++j) {
    for (int i = 0; i < 7; ++i) map.heights.push_back(-float((i * 5 + j * 3 + i * j * 2) % 11) / 8);
  }
  for (const Row& row : rows) {
    map.repeats = row.repeats == 1;
    const SurfaceDetail detail = detail_at(map, {row.u, row.v});
    EXPECT_NEAR(detail.height, row.height, 1e-12) << row.u;
    EXPECT_NEAR(detail.slope.x(), row.du, 1e-11);
    EXPECT_NEAR(detail.slope.y(), row.dv, 1e-11);
    EXPECT_NEAR(detail.curvature(0, 0), row.duu, 1e-10);
    EXPECT_NEAR(detail.curvature(0, 1), row.duv, 1e-10);
    EXPECT_NEAR(detail.curvature(1, 0), row.duv, 1e-10);
    EXPECT_NEAR(detail.curvature(1, 1), row.dvv, 1e-10);
    EXPECT_EQ(height_at(map, {row.u, row.v}), detail.height);
    EXPECT_EQ(slope_at(map, {row.u, row.v}), detail.slope);
    // The same numbers as a normal map's slopes.
    SurfaceMap normals = map;
    std::swap(normals.heights, normals.slopes_v);
    normals.slopes_u.assign(normals.slopes_v.size(), 0.5F);
    const SurfaceDetail slopes = detail_at(normals, {row.u, row.v});
    EXPECT_EQ(slopes.height, 0);
    EXPECT_EQ(slopes.slope.x(), 0.5);
    EXPECT_NEAR(slopes.slope.y(), row.height, 1e-12);
    EXPECT_EQ(slopes.curvature.row(0).norm(), 0);
    EXPECT_NEAR(slopes.curvature(1, 0), row.du, 1e-11);
    EXPECT_NEAR(slopes.curvature(1, 1), row.dv, 1e-11);
    EXPECT_EQ(slope_at(normals, {row.u, row.v}), slopes.slope);
  }
}

// What is flat has no slope at all, not even a rounded one: it must be silent.
TEST(TextureSampling, FlatIsExactlyFlat) {
  SurfaceMap map{"flat", 5, 6, 0.01, true, std::vector<float>(30, -0.0123F), {}, {}};
  EXPECT_TRUE(rc::check([&] {
    map.repeats = *rc::gen::arbitrary<bool>();
    const Vector2d uv(*rc::gen::inRange(-100000, 100000) * 1e-5,
                      *rc::gen::inRange(-100000, 100000) * 1e-5);
    const SurfaceDetail detail = detail_at(map, uv);
    RC_ASSERT(detail.height == double(-0.0123F));
    RC_ASSERT(detail.slope == Vector2d::Zero());
    RC_ASSERT(detail.curvature == Eigen::Matrix2d::Zero());
  }));
}

// A cosine of n texels a wave: its fundamental is sinc(1/n)^4 as high, and at the texels' centres
// the spline has the mean of the neighbours' with weights 1, 4, 1.
TEST(TextureSampling, ACosineHasTheDepthOfTheDoor) {
  const int n = 8;
  SurfaceMap map{"cosine", n, 4, 0.5, true, {}, {}, {}};
  for (int i = 0; i < 4 * n; ++i) {
    map.heights.push_back(float(std::cos(2 * std::numbers::pi * i / n)));
  }
  EXPECT_NEAR(height_at(map, {0.25, 0.7}), (4 + 2 * std::cos(2 * std::numbers::pi / n)) / 6, 1e-7);
  double fundamental = 0;
  const int steps = 400;
  for (int i = 0; i < steps; ++i) {
    const double u = n * 0.5 * i / steps;
    fundamental += height_at(map, {u, 0}) *
                   std::cos(2 * std::numbers::pi * (u - 0.25) / (n * 0.5)) * 2 / steps;
  }
  const double x = std::numbers::pi / n;
  EXPECT_NEAR(fundamental, std::pow(std::sin(x) / x, 4), 1e-6);
}

TEST(TextureSampling, NeverLeavesTheRangeAndHasTheSlopesOfItsHeights) {
  const SurfaceMap maps[] = {random_relief(9, 7, true), random_relief(9, 7, false)};
  EXPECT_TRUE(rc::check([&] {
    const SurfaceMap& map = maps[*rc::gen::inRange(0, 2)];
    const Vector2d uv(*rc::gen::inRange(-20000, 20000) * 1e-4,
                      *rc::gen::inRange(-20000, 20000) * 1e-4);
    const SurfaceDetail detail = detail_at(map, uv);
    RC_ASSERT(detail.height <= 0 && detail.height >= -1);
    const double step = 1e-5;
    for (int axis = 0; axis < 2; ++axis) {
      const Vector2d off = step * Vector2d::Unit(axis);
      const double slope = (height_at(map, uv + off) - height_at(map, uv - off)) / (2 * step);
      RC_ASSERT(std::abs(detail.slope[axis] - slope) < 1e-5);
      const Vector2d bend = (slope_at(map, uv + off) - slope_at(map, uv - off)) / (2 * step);
      RC_ASSERT((detail.curvature.col(axis) - bend).norm() < 2e-2);
    }
  }));
}

TEST(TextureSampling, RepeatsOrGoesOnBeyondItsEdges) {
  const SurfaceMap again = random_relief(6, 5, true), ends = random_relief(6, 5, false);
  for (const Vector2d& uv : {Vector2d(0.13, 0.02), Vector2d(0.59, 0.45), Vector2d(0.3, 0.2)}) {
    for (const int turns : {-1000, -3, 1, 2, 100000}) {
      const Vector2d far = uv + turns * again.size();
      EXPECT_NEAR(height_at(again, far), height_at(again, uv), 1e-9);
    }
  }
  EXPECT_EQ(height_at(ends, {-1e9, 1e9}), ends.heights[24]);
  EXPECT_EQ(slope_at(ends, {-1e9, 0.2}).x(), 0);
  EXPECT_EQ(height_at(ends, {1.9, -2.0}), ends.heights[5]);
  for (const SurfaceMap& map : {again, ends}) {
    EXPECT_TRUE(std::isnan(height_at(map, {NAN, 0.1})));
    EXPECT_TRUE(std::isnan(slope_at(map, {0.1, INFINITY}).x()));
    EXPECT_TRUE(std::isnan(height_at(map, {1e300, 0})));
  }
}

TEST(TextureSampling, TexelNormalsStepFromTexelToTexel) {
  SurfaceMap map{"steps", 4, 4, 0.01, true, {}, std::vector<float>(16), std::vector<float>(16)};
  map.slopes_u[6] = 1;  // column 2, row 1
  const Vec3 tilted = Vec3(-1, 0, 1).normalized();
  for (const double off : {0.0001, 0.005, 0.0099}) {
    EXPECT_NEAR((texel_normal(map, {0.02 + off, 0.01 + off}) - tilted).norm(), 0, 1e-7);
    EXPECT_NEAR((texel_normal(map, {0.02 + off - 0.04, 0.01 + off + 0.12}) - tilted).norm(), 0,
                1e-7);
    EXPECT_EQ(texel_normal(map, {0.01 + off, 0.01 + off}), Vec3::UnitZ());
    EXPECT_EQ(texel_normal(map, {0.02 + off, 0.02 + off}), Vec3::UnitZ());
  }
  const SurfaceMap relief = random_relief(6, 5, true);
  EXPECT_NEAR(
      (texel_normal(relief, {0.21, 0.39}) - normal_of(slope_at(relief, {0.25, 0.35}))).norm(), 0,
      1e-12);
  const SurfaceMap normals = normal_map_of(relief);
  EXPECT_NEAR((texel_normal(relief, {0.21, 0.39}) - texel_normal(normals, {0.21, 0.39})).norm(), 0,
              1e-6);
}

}  // namespace
}  // namespace carillon::solvers
