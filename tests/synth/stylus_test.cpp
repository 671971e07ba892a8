#include "synth/touch/stylus.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "synth/motion/lasting_force.hpp"
#include "tests/synth/scraped_face.hpp"

namespace carillon::synth {
namespace {

solvers::TexturedFace face_of(const solvers::SurfaceMap& map) {
  solvers::TexturedFace face;
  face.map = std::make_shared<const solvers::SurfaceMap>(map);
  face.size = {1, 1};
  return face;
}

/// A relief of one step from 0 down to -depth at x = 32 texels.
solvers::SurfaceMap step_map(double texel, double depth) {
  solvers::SurfaceMap map;
  map.width = 64;
  map.height = 4;
  map.texel = texel;
  map.repeats = false;
  for (int j = 0; j < map.height; ++j) {
    for (int i = 0; i < map.width; ++i) {
      map.heights.push_back(i < 32 ? 0.0F : static_cast<float>(-depth));
    }
  }
  return map;
}

TEST(Stylus, APathIsDrawnAtItsSpeed) {
  const std::vector<Vec3> corners = {{0, 0, 0}, {0.03, 0, 0}, {0.03, 0.04, 0}};
  const std::vector<Vec3> path = drawn_path(corners, 0.1, 1000);
  ASSERT_EQ(path.size(), 701u);
  EXPECT_LT((path[150] - Vec3(0.015, 0, 0)).norm(), 1e-12);
  EXPECT_LT((path[500] - Vec3(0.03, 0.02, 0)).norm(), 1e-12);
  EXPECT_LT((path[700] - corners[2]).norm(), 1e-12);
}

// Slowly drawn, the face holds the press up; on a slope it pushes by the slope times that: forces
// of statics, on both kinds of map.
TEST(Stylus, SlowlyDrawnTheForceIsThatOfTheSlope) {
  constexpr double kLength = 8e-3, kDepth = 2e-4, kSpeed = 0.01;
  const solvers::SurfaceMap relief = sine_map(kLength, kDepth, 64, 8);
  const std::vector<Vec3> corners = {{0.01, 0.5, 0}, {0.03, 0.5, 0}};
  const std::vector<Vec3> path = drawn_path(corners, kSpeed, 1000);
  Stylus stylus;
  stylus.radius = 0;
  for (const bool normal_map : {false, true}) {
    const auto face = face_of(normal_map ? normal_map_of(relief) : relief);
    const Touch touch = draw_stylus(face, path, stylus, {});
    ASSERT_EQ(touch.forces.size(), path.size());
    for (std::size_t k = 300; k + 1 < path.size(); ++k) {
      const Eigen::Vector2d slope = slope_at(*face.map, touch.tip[k].head<2>());
      EXPECT_NEAR(touch.forces[k].z(), 1, 0.02);
      EXPECT_NEAR(touch.forces[k].x(), -slope.x(), 0.02);
      // It sinks in by force over stiffness.
      const double height = normal_map ? 0 : height_at(*face.map, touch.tip[k].head<2>());
      EXPECT_NEAR(touch.tip[k].z(), height - 1 / stylus.stiffness, 1e-5);
    }
    EXPECT_EQ(touch.held_back, 0u);
    EXPECT_EQ(touch.limited, 0u);
  }
}

TEST(Stylus, OverAFlatFaceItFeelsThePressAlone) {
  const solvers::SurfaceMap map = sine_map(2e-3, 0, 16, 4);
  const std::vector<Vec3> corners = {{0.01, 0.5, 0}, {0.11, 0.5, 0}};
  Stylus stylus;
  stylus.friction = 0.3;
  const Touch touch = draw_stylus(face_of(map), drawn_path(corners, 0.2, 1000), stylus, {});
  for (std::size_t k = 300; k + 1 < touch.forces.size(); ++k) {
    EXPECT_NEAR(touch.forces[k].z(), 1, 1e-6);
    EXPECT_NEAR(touch.forces[k].x(), -0.3, 1e-3);
    EXPECT_NEAR(touch.forces[k].y(), 0, 1e-9);
  }
  // In the air nothing.
  Stylus held;
  held.press = 0;
  const std::vector<Vec3> above = {{0.01, 0.5, 0.01}, {0.11, 0.5, 0.01}};
  for (const Vec3& force :
       draw_stylus(face_of(map), drawn_path(above, 0.2, 1000), held, {}).forces) {
    EXPECT_EQ(force.norm(), 0.0);
  }
}

// On a relief there is contact only below its depth.
TEST(Stylus, FollowsAReliefDownAnEdgeWithinATexelAndATick) {
  constexpr double kTexel = 5e-4, kDepth = 2e-3, kSpeed = 0.05;
  const auto face = face_of(step_map(kTexel, kDepth));
  const std::vector<Vec3> corners = {{0.011, 1e-3, 0}, {0.021, 1e-3, 0}};
  const Touch touch = draw_stylus(face, drawn_path(corners, kSpeed, 1000), {}, {});
  std::size_t leaves = 0, lands = 0;
  for (std::size_t k = 20; k + 1 < touch.tip.size(); ++k) {
    if (leaves == 0 && touch.tip[k].z() < -0.05 * kDepth - 1 / 5000.0) leaves = k;
    if (lands == 0 && touch.tip[k].z() < -0.95 * kDepth) lands = k;
  }
  // The edge is a slope between the centres of two texels beside 16 mm.
  EXPECT_NEAR(touch.tip[leaves].x(), 0.016, 2 * kTexel);
  EXPECT_GT(lands, leaves);
  EXPECT_NEAR(touch.tip.back().z(), -kDepth - 1 / 5000.0, 1e-5);
}

// A wall: the tip is held back until the hand pulls it over, and nothing gives way to more than
// the largest force.
TEST(Stylus, UpAVerticalEdgeForcesStayBelowTheLargest) {
  for (const double depth : {5e-4, 2e-3, 2e-2}) {
    const auto face = face_of(step_map(1e-4, depth));
    const std::vector<Vec3> corners = {{0.005, 1e-4, -depth}, {0.001, 1e-4, -depth}};
    Stylus stylus;
    const Touch touch = draw_stylus(face, drawn_path(corners, 0.05, 1000), stylus, {});
    double most = 0;
    for (std::size_t k = 0; k < touch.tip.size(); ++k) {
      ASSERT_TRUE(touch.tip[k].allFinite());
      EXPECT_LE(touch.forces[k].norm(), stylus.largest_force * (1 + 1e-12));
      most = std::max(most, touch.forces[k].x());
      // It is not thrown off.
      EXPECT_LT(touch.tip[k].z(), 0.01);
    }
    EXPECT_GT(most, 1) << depth;
  }
}

// Steep and narrow valleys, where papers saw the tip swing between the sides: energy of tip and
// springs never grows while the hand stands still.
TEST(Stylus, InANarrowValleyEnergyNeverGrows) {
  for (const double texel : {2e-5, 1e-4}) {
    for (const double depth : {1e-4, 1e-3, 5e-3}) {
      for (const bool normal_map : {false, true}) {
        for (const double stiffness : {500.0, 5000.0, 50000.0}) {
          const solvers::SurfaceMap relief = sine_map(8 * texel, depth / 2, 8, 8);
          const auto face = face_of(normal_map ? normal_map_of(relief) : relief);
          Stylus stylus;
          stylus.stiffness = stiffness;
          stylus.press = 3;
          // Above the valley's side.
          const std::vector<Vec3> hand(2000, Vec3(0.01 + 3.3 * texel, 0.5, 1e-4));
          const Touch touch = draw_stylus(face, hand, stylus, {});
          const auto energy = [&](const Vec3& tip, const Vec3& velocity) {
            return stylus.mass * velocity.squaredNorm() / 2 +
                   stylus.hold * (tip - hand[0]).head<2>().squaredNorm() / 2 +
                   stylus.press * (tip.z() + depth);
          };
          double begin = energy(touch.tip[0], Vec3::Zero());
          if (normal_map) {
            // It stands for heights, and may give what lies below the start.
            const solvers::SurfaceMap heights = integrated_relief(*face.map);
            const float lowest = *std::min_element(heights.heights.begin(), heights.heights.end());
            begin += stylus.press *
                     (height_at(heights, hand[0].head<2>()) - static_cast<double>(lowest));
          }
          double swing = 0;
          for (std::size_t k = 0; k + 1 < touch.tip.size(); ++k) {
            ASSERT_TRUE(touch.tip[k].allFinite());
            const Vec3 way = touch.tip[k + 1] - touch.tip[k];
            EXPECT_LE(energy(touch.tip[k] + way / 2, way * touch.rate), begin * 1.01)
                << texel << ' ' << depth << ' ' << normal_map << ' ' << stiffness << ' ' << k;
            if (k > 1500) swing = std::max(swing, way.norm() * touch.rate);
          }
          // And it has come to rest.
          EXPECT_LT(swing, 0.02) << texel << ' ' << depth << ' ' << normal_map << ' ' << stiffness;
        }
      }
    }
  }
}

TEST(Stylus, RefusesPathsThatAreNone) {
  const auto face = face_of(sine_map(2e-3, 0, 16, 4));
  const std::vector<Vec3> nan = {{0, 0, 0}, {NAN, 0, 0}}, far = {{0, 0, 0}, {INFINITY, 0, 0}};
  for (const auto& path : {nan, far, std::vector<Vec3>{}}) {
    EXPECT_THROW(draw_stylus(face, path, {}, {}), core::InputError);
    EXPECT_THROW(drawn_path(path, 0.1, 1000), core::InputError);
  }
  const std::vector<Vec3> fine = {{0, 0, 0}, {0.1, 0, 0}};
  EXPECT_THROW(drawn_path(fine, 0, 1000), core::InputError);
  EXPECT_THROW(drawn_path(fine, 1e-12, 1000), core::InputError);
  EXPECT_THROW(drawn_path(fine, NAN, 1000), core::InputError);
  Stylus massless;
  massless.mass = 0;
  EXPECT_THROW(draw_stylus(face, fine, massless, {}), core::InputError);
  try {
    draw_stylus(face, nan, {}, {});
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("at tick 1"), std::string::npos);
  }
}

// The same place in touch and in sound: the drawn stylus is heard at speed over wavelength.
TEST(Stylus, IsHeardAtSpeedOverWavelength) {
  constexpr double kLength = 2e-3, kSpeed = 0.2;
  const auto face = face_of(sine_map(kLength, 2e-6, 32, 16));
  const std::vector<Vec3> corners = {{0.01, 0.5, 0}, {0.11, 0.5, 0}};
  Stylus stylus;
  const Touch touch = draw_stylus(face, drawn_path(corners, kSpeed, 1000), stylus, {});
  const Motion motion = motion_of(touch, face);
  ASSERT_GE(motion.contacts.size(), 1u);
  std::vector<MovingBody> bodies = {moving_stylus(stylus), {}};
  bodies[1].fixed = true;
  bodies[1].texture = face;
  LastingForceOptions options;
  options.roughness = 0;
  options.edge_radius = 0;
  LastingForces forces(motion, bodies, options);
  const LastingForce force = forces.force(motion.contacts.size() - 1);
  const Eigen::VectorXd heard = force.force.row(2).transpose();
  ASSERT_GT(heard.size(), 15000);
  // Rising zeros of a stretch of 0.2 s: 20 waves.
  int rises = 0;
  for (Eigen::Index n = 5000; n < 5000 + 8820; ++n) {
    rises += heard[n] < 0 && heard[n + 1] >= 0 ? 1 : 0;
  }
  EXPECT_NEAR(rises, 20, 1);
}

}  // namespace
}  // namespace carillon::synth
