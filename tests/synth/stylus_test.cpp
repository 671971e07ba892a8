#include "synth/touch/stylus.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "synth/motion/lasting_force.hpp"
#include "tests/synth/scraped_face.hpp"

namespace carillon::synth {
namespace {

render::maps::TexturedFace face_of(const render::maps::SurfaceMap& map) {
  render::maps::TexturedFace face;
  face.map = std::make_shared<const render::maps::SurfaceMap>(map);
  face.size = {1, 1};
  return face;
}

TEST(Stylus, APathIsDrawnAtItsSpeed) {
  const std::vector<Vec3> corners = {{0, 0, 0}, {0.03, 0, 0}, {0.03, 0.04, 0}};
  const std::vector<Vec3> path = touch::drawn_path(corners, 0.1, 1000);
  ASSERT_EQ(path.size(), 701u);
  EXPECT_LT((path[150] - Vec3(0.015, 0, 0)).norm(), 1e-12);
  EXPECT_LT((path[500] - Vec3(0.03, 0.02, 0)).norm(), 1e-12);
  EXPECT_LT((path[700] - corners[2]).norm(), 1e-12);
  // It ends at its end, also where that is no whole number of ticks away.
  EXPECT_EQ(touch::drawn_path(corners, 0.3, 1000).size(), 235u);
  EXPECT_EQ(touch::drawn_path(corners, 0.3, 1000).back(), corners[2]);
}

// Slowly drawn, the face holds the press up; on a slope it pushes by the slope times that: forces
// of statics, on both kinds of map.
TEST(Stylus, SlowlyDrawnTheForceIsThatOfTheSlope) {
  constexpr double full_length = 8e-3, groove_depth = 2e-4, sliding_speed = 0.01;
  const render::maps::SurfaceMap relief = sine_map(full_length, groove_depth, 64, 8);
  const std::vector<Vec3> corners = {{0.01, 0.5, 0}, {0.03, 0.5, 0}};
  const std::vector<Vec3> path = touch::drawn_path(corners, sliding_speed, 1000);
  touch::Stylus stylus;
  stylus.radius = 0;
  for (const bool normal_map : {false, true}) {
    const auto face = face_of(normal_map ? render::maps::normal_map_of(relief) : relief);
    const touch::Touch touch = touch::draw_stylus(face, path, stylus, {});
    ASSERT_EQ(touch.forces.size(), path.size());
    for (std::size_t k = 300; k + 1 < path.size(); ++k) {
      const Eigen::Vector2d slope = render::maps::slope_at(*face.map, touch.tip[k].head<2>());
      EXPECT_NEAR(touch.forces[k].z(), 1, 0.02);
      EXPECT_NEAR(touch.forces[k].x(), -slope.x(), 0.02);
      // It sinks in by force over stiffness.
      const double height =
          normal_map ? 0 : render::maps::height_at(*face.map, touch.tip[k].head<2>());
      EXPECT_NEAR(touch.tip[k].z(), height - 1 / stylus.stiffness, 1e-5);
    }
    EXPECT_EQ(touch.held_back, 0u);
    EXPECT_EQ(touch.limited, 0u);
  }
}

TEST(Stylus, OverAFlatFaceItFeelsThePressAlone) {
  const render::maps::SurfaceMap map = sine_map(2e-3, 0, 16, 4);
  const std::vector<Vec3> corners = {{0.01, 0.5, 0}, {0.11, 0.5, 0}};
  touch::Stylus stylus;
  stylus.friction = 0.3;
  const touch::Touch touch =
      touch::draw_stylus(face_of(map), touch::drawn_path(corners, 0.2, 1000), stylus, {});
  for (std::size_t k = 300; k + 1 < touch.forces.size(); ++k) {
    EXPECT_NEAR(touch.forces[k].z(), 1, 1e-6);
    EXPECT_NEAR(touch.forces[k].x(), -0.3, 1e-3);
    EXPECT_NEAR(touch.forces[k].y(), 0, 1e-9);
  }
  // In the air nothing.
  touch::Stylus held;
  held.press = 0;
  const std::vector<Vec3> above = {{0.01, 0.5, 0.01}, {0.11, 0.5, 0.01}};
  for (const Vec3& force :
       touch::draw_stylus(face_of(map), touch::drawn_path(above, 0.2, 1000), held, {}).forces) {
    EXPECT_EQ(force.norm(), 0.0);
  }
}

// The tick is that of what is given out, not of the tip's own motion: a slow hand is set down on a
// slope of wide texels, and at common times the tip is where it is at any rate.
TEST(Stylus, RatesDoNotChangeTheTipsWay) {
  const auto face = face_of(sine_map(0.32, 0.01, 64, 4));
  const std::vector<Vec3> corners = {{0.01, 0.5, 1e-3}, {0.012, 0.5, 0}};
  touch::Stylus stylus;
  stylus.friction = 0.3;
  const touch::Touch fine =
      touch::draw_stylus(face, touch::drawn_path(corners, 0.01, 1000), stylus, {1000});
  for (const int every : {2, 10, 20}) {
    const double rate = 1000.0 / every;
    const touch::Touch coarse =
        touch::draw_stylus(face, touch::drawn_path(corners, 0.01, rate), stylus, {rate});
    for (std::size_t k = 0; k + 1 < coarse.tip.size(); ++k) {
      EXPECT_LT((coarse.tip[k] - fine.tip[k * every]).norm(), 1.5e-5) << every << ' ' << k;
    }
  }
}

// On a relief there is contact only below its depth.
TEST(Stylus, FollowsAReliefDownAnEdgeWithinATexelAndATick) {
  constexpr double texel_size = 5e-4, groove_depth = 2e-3, sliding_speed = 0.05;
  const auto face = face_of(step_map(texel_size, groove_depth));
  const std::vector<Vec3> corners = {{0.011, 1e-3, 0}, {0.021, 1e-3, 0}};
  const touch::Touch touch =
      touch::draw_stylus(face, touch::drawn_path(corners, sliding_speed, 1000), {}, {});
  std::size_t leaves = 0, lands = 0;
  for (std::size_t k = 20; k + 1 < touch.tip.size(); ++k) {
    if (leaves == 0 && touch.tip[k].z() < -0.05 * groove_depth - 1 / 5000.0) leaves = k;
    if (lands == 0 && touch.tip[k].z() < -0.95 * groove_depth) lands = k;
  }
  // The edge is a slope between the centres of two texels beside 16 mm.
  EXPECT_NEAR(touch.tip[leaves].x(), 0.016, 2 * texel_size);
  EXPECT_GT(lands, leaves);
  EXPECT_NEAR(touch.tip.back().z(), -groove_depth - 1 / 5000.0, 1e-5);
}

// The same place in touch and in sound: the drawn stylus is heard at speed over wavelength.
TEST(Stylus, IsHeardAtSpeedOverWavelength) {
  constexpr double full_length = 2e-3, sliding_speed = 0.2;
  const auto face = face_of(sine_map(full_length, 2e-6, 32, 16));
  const std::vector<Vec3> corners = {{0.01, 0.5, 0}, {0.11, 0.5, 0}};
  touch::Stylus stylus;
  const touch::Touch touch =
      touch::draw_stylus(face, touch::drawn_path(corners, sliding_speed, 1000), stylus, {});
  const motion::Motion motion = touch::motion_of(touch, face);
  ASSERT_GE(motion.contacts.size(), 1u);
  std::vector<motion::MovingBody> bodies = {touch::moving_stylus(stylus), {}};
  bodies[1].fixed = true;
  bodies[1].texture = face;
  motion::LastingForceOptions options;
  options.roughness = 0;
  options.edge_radius = 0;
  motion::LastingForces forces(motion, bodies, options);
  const motion::LastingForce force = forces.force(motion.contacts.size() - 1);
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
