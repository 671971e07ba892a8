#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/random.hpp"
#include "render/maps/generated_maps.hpp"

namespace carillon::solvers {
namespace {

using Eigen::Vector2d;

/// Every place under the ball, a fiftieth of a texel apart.
double by_trying(const render::maps::SurfaceMap& map, const Vector2d& uv, double radius) {
  double best = -INFINITY;
  const double step = map.texel / 50;
  const int count = static_cast<int>(radius / step);
  for (int j = -count; j <= count; ++j) {
    for (int i = -count; i <= count; ++i) {
      const double off2 = (i * i + j * j) * step * step;
      if (off2 > radius * radius) continue;
      best = std::max(best, render::maps::height_at(map, uv + Vector2d(i, j) * step) +
                                std::sqrt(radius * radius - off2) - radius);
    }
  }
  return best;
}

TEST(TracedHeight, IsTheHighestOfAllPlacesUnderTheBall) {
  for (const char* name : {"brick", "pebbles", "noise"}) {
    render::maps::SurfaceMap map = render::maps::generate_map(name, {}, 100, 3);
    if (std::string(name) == "noise") {
      for (float& height : map.heights) height *= 5;  // steep: slopes of 1 and more
    }
    const double depth = -*std::min_element(map.heights.begin(), map.heights.end());
    core::RandomStream random(5, 0, name);
    for (const double texels : {0.4, 1.3, 6.0}) {
      for (int k = 0; k < 12; ++k) {
        const double v = random.uniform(), u = random.uniform();
        const Vector2d uv = Vector2d(u, v).cwiseProduct(map.size());
        const double radius = texels * map.texel;
        const double truth = by_trying(map, uv, radius);
        const double found = render::maps::traced_height(map, uv, radius);
        EXPECT_GT(found, truth - 1e-5 * depth) << name << texels;
        EXPECT_LT(found, truth + 2e-3 * depth) << name << texels;
        map.repeats = false;
        EXPECT_NEAR(render::maps::traced_height(map, uv, radius), by_trying(map, uv, radius),
                    2e-3 * depth);
        map.repeats = true;
      }
    }
  }
}

// A ball over a sine: in the plane across, the tip's height by the closed form of a circle on the
// curve, found by bisection on the place of contact.
TEST(TracedHeight, OfABallOverASine) {
  const double wavelength = 0.01, depth = 0.002;
  const render::maps::SurfaceMap map = render::maps::generate_map(
      "grooves", {{"wavelength", wavelength}, {"depth", depth}, {"waves", 4}}, 512, 0);
  const double k = 2 * std::numbers::pi / wavelength;
  // Curvature of the valley is a k^2 = 395 / m: a ball of 20 mm touches at two places.
  const double a = depth / 2, radius = 0.02;
  double low = 0, high = wavelength / 2;  // distance of the contact from the valley's middle
  for (int i = 0; i < 100; ++i) {
    const double x = (low + high) / 2;
    const double rise = a * k * std::sin(k * x) - x / std::sqrt(radius * radius - x * x);
    (rise > 0 ? low : high) = x;
  }
  const double expected =
      -a - a * std::cos(k * low) + std::sqrt(radius * radius - low * low) - radius;
  // Ridges lie at whole wavelengths plus half a one (the map's first texel begins a valley).
  EXPECT_NEAR(render::maps::height_at(map, {wavelength / 2, 0}), 0, 1e-3 * depth);
  EXPECT_NEAR(render::maps::traced_height(map, {wavelength, 0.003}, radius), expected,
              2e-4 * depth);
  EXPECT_NEAR(render::maps::traced_height(map, {wavelength / 2, 0.003}, radius), 0, 1e-3 * depth);
  // A ball of 1 mm fits into the valley.
  EXPECT_NEAR(render::maps::traced_height(map, {wavelength, 0.003}, 0.001), -depth, 1e-3 * depth);
}

TEST(TracedHeight, OfNoRadiusIsTheSurface) {
  const render::maps::SurfaceMap map = render::maps::generate_map("pebbles", {}, 64, 1);
  for (const double u : {0.01, 0.0333, 0.15}) {
    EXPECT_EQ(render::maps::traced_height(map, {u, 0.02}, 0),
              render::maps::height_at(map, {u, 0.02}));
    const double slope = render::maps::slope_at(map, {u, 0.02}).norm();
    const double tiny = 1e-9;
    EXPECT_NEAR(
        render::maps::traced_height(map, {u, 0.02}, tiny) - render::maps::height_at(map, {u, 0.02}),
        tiny * (std::hypot(1, slope) - 1), 1e-13);
  }
  EXPECT_EQ(render::maps::traced_map(map, 0).heights, map.heights);
  EXPECT_TRUE(std::isnan(render::maps::traced_height(map, {NAN, 0}, 0.01)));
}

TEST(TracedMap, HasTheTracedHeightsAtItsTexelsAndBetweenThem) {
  for (const bool repeats : {true, false}) {
    for (const char* name : {"brick", "noise"}) {
      render::maps::SurfaceMap map = render::maps::generate_map(name, {}, 300, 3);
      map.repeats = repeats;
      const double depth = -*std::min_element(map.heights.begin(), map.heights.end());
      for (const double texels : {0.5, 5.0, 60.0}) {
        const double radius = texels * map.texel;
        const render::maps::SurfaceMap traced = render::maps::traced_map(map, radius);
        double worst = 0, worst_between = 0, square = 0;
        core::RandomStream random(1, 0, "places");
        for (int n = 0; n < 300; ++n) {
          const Eigen::Array2i texel(static_cast<int>(random.index(std::uint64_t(map.width))),
                                     static_cast<int>(random.index(std::uint64_t(map.height))));
          const Vector2d centre = (texel.cast<double>() + 0.5).matrix() * map.texel;
          worst = std::max(worst, std::abs(render::maps::height_at(traced, centre) -
                                           render::maps::traced_height(map, centre, radius)));
          const Vector2d between =
              centre + Vector2d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)) * map.texel;
          const double error = std::abs(render::maps::height_at(traced, between) -
                                        render::maps::traced_height(map, between, radius));
          worst_between = std::max(worst_between, error);
          square += error * error / 300;
        }
        EXPECT_LT(worst, 0.002 * depth) << name << texels;
        // Slopes change by up to 2 where the ball drops from one edge of a joint to the other.
        EXPECT_LT(worst_between, map.texel / 3) << name << texels;
        EXPECT_LT(std::sqrt(square), map.texel / 20) << name << texels;
        for (const float height : traced.heights) EXPECT_LE(height, 0);
      }
    }
  }
}

TEST(TracedMap, OfLargeBallsIsTheTopAndOfNormalMapsTheirHeights) {
  const render::maps::SurfaceMap map = render::maps::generate_map("grooves", {}, 64, 3);
  const render::maps::SurfaceMap large = render::maps::traced_map(map, 1e3);
  const double top = render::maps::height_at(map, {0.001, 0});
  for (const float height : large.heights) EXPECT_NEAR(height, top, 1e-7);
  const render::maps::SurfaceMap normals = render::maps::normal_map_of(map);
  EXPECT_EQ(render::maps::traced_map(normals, 0.004).heights,
            render::maps::traced_map(render::maps::integrated_relief(normals), 0.004).heights);
  EXPECT_EQ(
      render::maps::traced_height(normals, {0.01, 0.01}, 0.004),
      render::maps::traced_height(render::maps::integrated_relief(normals), {0.01, 0.01}, 0.004));
  EXPECT_THROW(render::maps::traced_map(map, -1), core::InputError);
  EXPECT_THROW(render::maps::traced_height(map, {0, 0}, NAN), core::InputError);
}

}  // namespace
}  // namespace carillon::solvers
