#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "core/random.hpp"
#include "render/maps/generated_maps.hpp"
#include "render/maps/surface_map.hpp"

namespace carillon::solvers {
namespace {

using Eigen::Vector2d;

render::maps::SurfaceMap random_relief(int width, int height, bool repeats,
                                       std::uint64_t seed = 1) {
  core::RandomStream random(seed, 0, "test");
  render::maps::SurfaceMap map{"random", width, height, 0.1, repeats, {}, {}, {}};
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
  render::maps::SurfaceMap map{"reference", 7, 5, 0.25, true, {}, {}, {}};
  for (int j = 0; j < 5; ++j) {
    for (int i = 0; i < 7; ++i) map.heights.push_back(-float((i * 5 + j * 3 + i * j * 2) % 11) / 8);
  }
  for (const Row& row : rows) {
    map.repeats = row.repeats == 1;
    const render::maps::SurfaceDetail detail = render::maps::detail_at(map, {row.u, row.v});
    EXPECT_NEAR(detail.height, row.height, 1e-12) << row.u;
    EXPECT_NEAR(detail.slope.x(), row.du, 1e-11);
    EXPECT_NEAR(detail.slope.y(), row.dv, 1e-11);
    EXPECT_NEAR(detail.curvature(0, 0), row.duu, 1e-10);
    EXPECT_NEAR(detail.curvature(0, 1), row.duv, 1e-10);
    EXPECT_NEAR(detail.curvature(1, 0), row.duv, 1e-10);
    EXPECT_NEAR(detail.curvature(1, 1), row.dvv, 1e-10);
    EXPECT_EQ(render::maps::height_at(map, {row.u, row.v}), detail.height);
    EXPECT_EQ(render::maps::slope_at(map, {row.u, row.v}), detail.slope);
    // The same numbers as a normal map's slopes.
    render::maps::SurfaceMap normals = map;
    std::swap(normals.heights, normals.slopes_v);
    normals.slopes_u.assign(normals.slopes_v.size(), 0.5F);
    const render::maps::SurfaceDetail slopes = render::maps::detail_at(normals, {row.u, row.v});
    EXPECT_EQ(slopes.height, 0);
    EXPECT_EQ(slopes.slope.x(), 0.5);
    EXPECT_NEAR(slopes.slope.y(), row.height, 1e-12);
    EXPECT_EQ(slopes.curvature.row(0).norm(), 0);
    EXPECT_NEAR(slopes.curvature(1, 0), row.du, 1e-11);
    EXPECT_NEAR(slopes.curvature(1, 1), row.dv, 1e-11);
    EXPECT_EQ(render::maps::slope_at(normals, {row.u, row.v}), slopes.slope);
  }
}

// What is flat has no slope at all, not even a rounded one: it must be silent.
TEST(TextureSampling, FlatIsExactlyFlat) {
  render::maps::SurfaceMap map{"flat", 5, 6, 0.01, true, std::vector<float>(30, -0.0123F), {}, {}};
  EXPECT_TRUE(rc::check([&] {
    map.repeats = *rc::gen::arbitrary<bool>();
    const Vector2d uv(*rc::gen::inRange(-100000, 100000) * 1e-5,
                      *rc::gen::inRange(-100000, 100000) * 1e-5);
    const render::maps::SurfaceDetail detail = render::maps::detail_at(map, uv);
    RC_ASSERT(detail.height == double(-0.0123F));
    RC_ASSERT(detail.slope == Vector2d::Zero());
    RC_ASSERT(detail.curvature == Eigen::Matrix2d::Zero());
  }));
}

// A cosine of n texels a wave: its fundamental is sinc(1/n)^4 as high, and at the texels' centres
// the spline has the mean of the neighbours' with weights 1, 4, 1.
TEST(TextureSampling, ACosineHasTheDepthOfTheDoor) {
  const int n = 8;
  render::maps::SurfaceMap map{"cosine", n, 4, 0.5, true, {}, {}, {}};
  for (int i = 0; i < 4 * n; ++i) {
    map.heights.push_back(float(std::cos(2 * std::numbers::pi * i / n)));
  }
  EXPECT_NEAR(render::maps::height_at(map, {0.25, 0.7}),
              (4 + 2 * std::cos(2 * std::numbers::pi / n)) / 6, 1e-7);
  double fundamental = 0;
  const int steps = 400;
  for (int i = 0; i < steps; ++i) {
    const double u = n * 0.5 * i / steps;
    fundamental += render::maps::height_at(map, {u, 0}) *
                   std::cos(2 * std::numbers::pi * (u - 0.25) / (n * 0.5)) * 2 / steps;
  }
  const double x = std::numbers::pi / n;
  EXPECT_NEAR(fundamental, std::pow(std::sin(x) / x, 4), 1e-6);
}

TEST(TextureSampling, NeverLeavesTheRangeAndHasTheSlopesOfItsHeights) {
  const render::maps::SurfaceMap maps[] = {random_relief(9, 7, true), random_relief(9, 7, false)};
  EXPECT_TRUE(rc::check([&] {
    const render::maps::SurfaceMap& map = maps[*rc::gen::inRange(0, 2)];
    const Vector2d uv(*rc::gen::inRange(-20000, 20000) * 1e-4,
                      *rc::gen::inRange(-20000, 20000) * 1e-4);
    const render::maps::SurfaceDetail detail = render::maps::detail_at(map, uv);
    RC_ASSERT(detail.height <= 0 && detail.height >= -1);
    const double step = 1e-5;
    for (int axis = 0; axis < 2; ++axis) {
      const Vector2d off = step * Vector2d::Unit(axis);
      const double slope =
          (render::maps::height_at(map, uv + off) - render::maps::height_at(map, uv - off)) /
          (2 * step);
      RC_ASSERT(std::abs(detail.slope[axis] - slope) < 1e-5);
      const Vector2d bend =
          (render::maps::slope_at(map, uv + off) - render::maps::slope_at(map, uv - off)) /
          (2 * step);
      RC_ASSERT((detail.curvature.col(axis) - bend).norm() < 2e-2);
    }
  }));
}

TEST(TextureSampling, RepeatsOrGoesOnBeyondItsEdges) {
  const render::maps::SurfaceMap again = random_relief(6, 5, true),
                                 ends = random_relief(6, 5, false);
  for (const Vector2d& uv : {Vector2d(0.13, 0.02), Vector2d(0.59, 0.45), Vector2d(0.3, 0.2)}) {
    for (const int turns : {-1000, -3, 1, 2, 100000}) {
      const Vector2d far = uv + turns * again.size();
      EXPECT_NEAR(render::maps::height_at(again, far), render::maps::height_at(again, uv), 1e-9);
    }
  }
  EXPECT_EQ(render::maps::height_at(ends, {-1e9, 1e9}), ends.heights[24]);
  EXPECT_EQ(render::maps::slope_at(ends, {-1e9, 0.2}).x(), 0);
  EXPECT_EQ(render::maps::height_at(ends, {1.9, -2.0}), ends.heights[5]);
  for (const render::maps::SurfaceMap& map : {again, ends}) {
    EXPECT_TRUE(std::isnan(render::maps::height_at(map, {NAN, 0.1})));
    EXPECT_TRUE(std::isnan(render::maps::slope_at(map, {0.1, INFINITY}).x()));
    EXPECT_TRUE(std::isnan(render::maps::height_at(map, {1e300, 0})));
  }
}

TEST(TextureSampling, TexelNormalsStepFromTexelToTexel) {
  render::maps::SurfaceMap map{
      "steps", 4, 4, 0.01, true, {}, std::vector<float>(16), std::vector<float>(16)};
  map.slopes_u[6] = 1;  // column 2, row 1
  const Vec3 tilted = Vec3(-1, 0, 1).normalized();
  for (const double off : {0.0001, 0.005, 0.0099}) {
    EXPECT_NEAR((render::maps::texel_normal(map, {0.02 + off, 0.01 + off}) - tilted).norm(), 0,
                1e-7);
    EXPECT_NEAR(
        (render::maps::texel_normal(map, {0.02 + off - 0.04, 0.01 + off + 0.12}) - tilted).norm(),
        0, 1e-7);
    EXPECT_EQ(render::maps::texel_normal(map, {0.01 + off, 0.01 + off}), Vec3::UnitZ());
    EXPECT_EQ(render::maps::texel_normal(map, {0.02 + off, 0.02 + off}), Vec3::UnitZ());
  }
  const render::maps::SurfaceMap relief = random_relief(6, 5, true);
  EXPECT_NEAR((render::maps::texel_normal(relief, {0.21, 0.39}) -
               render::maps::normal_of(render::maps::slope_at(relief, {0.25, 0.35})))
                  .norm(),
              0, 1e-12);
  const render::maps::SurfaceMap normals = render::maps::normal_map_of(relief);
  EXPECT_NEAR((render::maps::texel_normal(relief, {0.21, 0.39}) -
               render::maps::texel_normal(normals, {0.21, 0.39}))
                  .norm(),
              0, 1e-6);
}

}  // namespace
}  // namespace carillon::solvers
