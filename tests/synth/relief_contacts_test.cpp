#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.hpp"
#include "render/maps/generated_maps.hpp"
#include "synth/motion/convex_hull.hpp"
#include "synth/motion/detail/relief_contacts.hpp"
#include "tests/synth/moving_bodies.hpp"

namespace carillon::synth {
namespace {

motion::ReliefPeaks peaks_of(const render::maps::SurfaceMap& map) {
  return motion::ReliefPeaks(std::make_shared<const render::maps::SurfaceMap>(map));
}

TEST(ReliefContacts, ABallOnAFlatReliefTouchesBelowItsCentre) {
  const motion::ReliefPeaks peaks = peaks_of(flat_relief(0.002));
  const std::vector<motion::ReliefContact> found =
      motion::ball_on_relief(peaks, {1, 1}, {0.5003, 0.5001, 0.0079}, 0.01);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].depth, 0.0001, 1e-9);
  EXPECT_NEAR((found[0].point - Vec3(0.5003, 0.5001, -0.0021)).norm(), 0, 1e-7);
  EXPECT_NEAR((found[0].normal - Vec3::UnitZ()).norm(), 0, 1e-6);
  EXPECT_TRUE(motion::ball_on_relief(peaks, {1, 1}, {0.5, 0.5, 0.0081}, 0.01).empty());
  EXPECT_TRUE(motion::ball_on_relief(peaks, {1, 1}, {1.5, 0.5, 0.005}, 0.01).empty());
}

// Where ball and relief touch their slopes agree, and a ball across a groove touches both sides.
TEST(ReliefContacts, ABallInAGrooveTouchesBothSides) {
  const double wave = 0.016, depth = 0.004, radius = 0.01;
  const render::maps::SurfaceMap map = render::maps::generate_map(
      "grooves", {{"wavelength", wave}, {"depth", depth}, {"waves", 8}}, 512, 0);
  const motion::ReliefPeaks peaks = peaks_of(map);
  // Above the bottom of a groove, 0.1 mm deeper than a ball at rest would be.
  double bottom = wave / 2;
  for (double u = wave / 2; u < 1.5 * wave; u += wave / 400) {
    if (render::maps::height_at(map, {u, 0.01}) < render::maps::height_at(map, {bottom, 0.01}))
      bottom = u;
  }
  const Eigen::Vector2d place(bottom, 0.01);
  const double rest = render::maps::traced_height(map, place, radius) + radius;
  const std::vector<motion::ReliefContact> found =
      motion::ball_on_relief(peaks, {1, 1}, {place.x(), place.y(), rest - 1e-4}, radius);
  ASSERT_EQ(found.size(), 2u);
  const Vec3 centre(place.x(), place.y(), rest - 1e-4);
  for (const motion::ReliefContact& contact : found) {
    const Vec3 of_ball = (centre - contact.point) / radius;
    EXPECT_NEAR((of_ball - contact.normal).norm(), 0, 1e-3);
    EXPECT_NEAR(contact.depth / contact.normal.z(), 1e-4, 2e-6);
  }
  EXPECT_NEAR(found[0].point.x() + found[1].point.x(), 2 * bottom, 1e-4);
}

TEST(ReliefContacts, AFlatBoxTouchesFarApart) {
  const motion::ReliefPeaks peaks = peaks_of(flat_relief(0.001));
  const motion::MovingBody box = box_body({0.04, 0.03, 0.02});
  std::vector<Vec3> points;
  for (const Vec3& p : box.hulls[0]) points.push_back(p + Vec3(0.5, 0.5, 0.01 - 0.0011));
  const std::vector<solvers::mesh::Triangle> bottom = {{0, 2, 1}, {1, 2, 3}};  // seen from below
  const std::vector<motion::ReliefContact> found =
      motion::hull_on_relief(peaks, {1, 1}, points, bottom);
  ASSERT_EQ(found.size(), motion::max_relief_contacts);
  Eigen::Vector2d low(1, 1), high(0, 0);
  for (const motion::ReliefContact& contact : found) {
    EXPECT_NEAR(contact.depth, 1e-4, 1e-9);
    low = low.cwiseMin(contact.point.head<2>());
    high = high.cwiseMax(contact.point.head<2>());
  }
  EXPECT_GT(high.x() - low.x(), 0.035);
  EXPECT_GT(high.y() - low.y(), 0.025);
}

struct Deepest {
  double distance = std::numeric_limits<double>::infinity();  ///< along the face's normal [m]
  double depth = 0;                                           ///< along the relief's [m]
};

/// Least distance from a relief to a convex body over all texels and the body's corners, whose
/// lower side is the highest of the planes that look down: no triangle is looked for.
Deepest deepest_of(const render::maps::SurfaceMap& map, const Eigen::Vector2d& size,
                   const solvers::mesh::SurfaceMesh& hull) {
  Deepest deepest;
  const auto look = [&](const Eigen::Vector2d& uv, double low) {
    const double distance = low - render::maps::height_at(map, uv);
    if (!(distance < deepest.distance)) return;
    deepest = {distance, -distance * render::maps::normal_of(render::maps::slope_at(map, uv)).z()};
  };
  for (int v = 0; (v + 0.5) * map.texel < size.y(); ++v) {
    for (int u = 0; (u + 0.5) * map.texel < size.x(); ++u) {
      const Eigen::Vector2d uv((u + 0.5) * map.texel, (v + 0.5) * map.texel);
      double low = -std::numeric_limits<double>::infinity(), high = -low;
      bool inside = true;
      for (const solvers::mesh::Triangle& t : hull.triangles) {
        const auto at = [&](std::size_t k) {
          return hull.vertices[static_cast<std::size_t>(t[k])];
        };
        const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
        const double level = normal.dot(at(0)) - normal.head<2>().dot(uv);  // normal.z z <= level
        if (normal.z() < -1e-9) {
          low = std::max(low, level / normal.z());
        } else if (normal.z() > 1e-9) {
          high = std::min(high, level / normal.z());
        } else {
          inside = inside && level >= 0;
        }
      }
      if (inside && low <= high && low < 0) look(uv, low);
    }
  }
  for (const Vec3& p : hull.vertices) {
    const bool on = p.x() >= 0 && p.y() >= 0 && p.x() <= size.x() && p.y() <= size.y();
    if (on && p.z() < 0) look(p.head<2>(), p.z());
  }
  return deepest;
}

// Whatever is passed over unseen, the deepest place is that of a look at every texel.
TEST(ReliefContacts, TheDeepestOfAHullIsThatOfAllTexels) {
  int touching = 0, apart = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    core::RandomStream random(7, seed, "hull");
    const std::vector<std::string> names = {"brick", "grooves", "pebbles", "noise"};
    // 100 texels are no whole number of blocks.
    auto made = std::make_shared<render::maps::SurfaceMap>(
        render::maps::generate_map(names[seed % 4], {}, seed % 3 == 0 ? 100 : 96, seed));
    made->repeats = seed % 5 != 0;
    const render::maps::SurfaceMap& map = *made;
    const double side = map.size().x();
    const Eigen::Vector2d size = Eigen::Vector2d(1.3, 1.7) * side;
    std::vector<Vec3> points;
    if (seed % 2 == 0) {
      points =
          box_body(Vec3(random.uniform(0.1, 0.8), random.uniform(0.1, 0.8), 0.2) * side).hulls[0];
    } else {
      for (int k = 0; k < 20; ++k) {
        points.push_back(Vec3(random.normal(), random.normal(), random.normal()).normalized() *
                         0.4 * side);
      }
    }
    const double tilt = seed % 4 < 2 ? 0 : random.uniform(0, 0.5);
    const Eigen::AngleAxisd turn(tilt, Vec3(random.normal(), random.normal(), 0).normalized());
    const Vec3 to(random.uniform(0, size.x()), random.uniform(0, size.y()), 0);
    double lowest = 0;
    for (Vec3& p : points) {
      p = turn * p + to;
      lowest = std::min(lowest, p.z());
    }
    const double deepest = *std::min_element(map.heights.begin(), map.heights.end());
    const double sink = random.uniform(0.3, 1.2) * deepest - lowest;
    for (Vec3& p : points) p.z() += sink;
    const solvers::mesh::SurfaceMesh hull = motion::convex_hull(points);
    const Deepest minimum = deepest_of(map, size, hull);
    const std::vector<motion::ReliefContact> found =
        motion::hull_on_relief(motion::ReliefPeaks(made), size, hull.vertices, hull.triangles);
    if (!(minimum.distance < 0)) {
      EXPECT_TRUE(found.empty()) << seed;
      ++apart;
      continue;
    }
    ++touching;
    ASSERT_FALSE(found.empty()) << seed;
    double depth = 0;
    for (const motion::ReliefContact& contact : found) {
      const double distance = contact.depth / contact.normal.z();
      const double height = render::maps::height_at(map, contact.point.head<2>());
      EXPECT_NEAR(distance, height - contact.point.z(), 1e-12);
      EXPECT_LE(distance, -minimum.distance + 1e-9 * side) << seed;
      depth = std::max(depth, contact.depth);
    }
    EXPECT_GE(depth, minimum.depth - 1e-9 * side) << seed;
  }
  EXPECT_GT(touching, 200);
  EXPECT_GT(apart, 5);
}

// Beyond its edges a map goes on as high as its last texels are, which the spline rounds off
// inside.
TEST(ReliefContacts, EdgesThatGoOnAreAsHighAsTheirTexels) {
  render::maps::SurfaceMap map = flat_relief(0.001);
  map.repeats = false;
  for (int v = 0; v < map.height; ++v) {
    map.heights[static_cast<std::size_t>((v + 1) * map.width - 1)] = 0;
  }
  const motion::ReliefPeaks peaks = peaks_of(map);
  const double side = map.size().x(), depth = 1e-6;
  const Eigen::Vector2d size(3 * side, side);
  const double top = render::maps::height_at(map, {2 * side, side / 2});
  ASSERT_NEAR(top, 0, 1e-12);
  ASSERT_LT(render::maps::height_at(map, {side - map.texel / 2, side / 2}), -1e-4);
  std::vector<Vec3> points;
  const motion::MovingBody box = box_body(Vec3(0.4, 0.4, 0.4) * side);
  for (const Vec3& p : box.hulls[0]) {
    points.push_back(p + Vec3(2 * side, side / 2, 0.2 * side - depth));
  }
  const solvers::mesh::SurfaceMesh hull = motion::convex_hull(points);
  const std::vector<motion::ReliefContact> found =
      motion::hull_on_relief(peaks, size, hull.vertices, hull.triangles);
  ASSERT_FALSE(found.empty());
  EXPECT_NEAR(found[0].depth, depth, 1e-9);
  const std::vector<motion::ReliefContact> ball =
      motion::ball_on_relief(peaks, size, {2 * side, side / 2, side - depth}, side);
  ASSERT_FALSE(ball.empty());
  EXPECT_NEAR(ball[0].depth, depth, 1e-9);
}

// The same of a ball, whose contacts lie between the texels.
TEST(ReliefContacts, TheDeepestOfABallIsNoLessThanThatOfAllTexels) {
  int touching = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    core::RandomStream random(8, seed, "ball");
    const std::vector<std::string> names = {"brick", "grooves", "pebbles", "noise"};
    const auto made = std::make_shared<const render::maps::SurfaceMap>(
        render::maps::generate_map(names[seed % 4], {}, 100, seed));
    const render::maps::SurfaceMap& map = *made;
    const Eigen::Vector2d size = 1.5 * map.size();
    const double radius = random.uniform(0.05, 0.6) * size.x();
    const double deepest = *std::min_element(map.heights.begin(), map.heights.end());
    const Vec3 centre(random.uniform(0, size.x()), random.uniform(0, size.y()),
                      radius + random.uniform(0, 1) * deepest);
    double minimum = 0;
    for (int v = 0; v < 150; ++v) {
      for (int u = 0; u < 150; ++u) {
        const Eigen::Vector2d uv((u + 0.5) * map.texel, (v + 0.5) * map.texel);
        const double inside = radius * radius - (uv - centre.head<2>()).squaredNorm();
        if (!(inside > 0)) continue;
        const double low = centre.z() - std::sqrt(inside);
        minimum = std::min(minimum, low - render::maps::height_at(map, uv));
      }
    }
    const std::vector<motion::ReliefContact> found =
        motion::ball_on_relief(motion::ReliefPeaks(made), size, centre, radius);
    if (!(minimum < 0)) continue;
    ++touching;
    ASSERT_FALSE(found.empty()) << seed;
    double maximum = 0;
    for (const motion::ReliefContact& contact : found) {
      maximum = std::max(maximum, contact.depth / contact.normal.z());
    }
    EXPECT_GE(maximum, -minimum - 1e-12) << seed;
    EXPECT_LE(maximum, -minimum + map.texel) << seed;
  }
  EXPECT_GT(touching, 30);
}

}  // namespace
}  // namespace carillon::synth
