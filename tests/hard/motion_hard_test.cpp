// What could strike up in a motion: docs/hard-cases.md says what each must come to.
#include <gtest/gtest.h>

#include <cmath>

#include "render/maps/generated_maps.hpp"
#include "tests/synth/moving_bodies.hpp"

namespace carillon::synth {
namespace {

constexpr double gravity = 9.80665;

motion::MotionOptions lasting(double seconds) {
  motion::MotionOptions options;
  options.seconds = seconds;
  return options;
}

void expect_finite(const motion::Motion& motion) {
  for (const double energy : motion.energy) ASSERT_TRUE(std::isfinite(energy));
  for (const motion::Impact& impact : motion.impacts) {
    ASSERT_TRUE(impact.impulse.allFinite() && std::isfinite(impact.duration));
  }
  for (const motion::LastingContact& contact : motion.contacts) {
    for (const motion::ContactStep& step : contact.steps) {
      ASSERT_TRUE(step.force.allFinite() && step.sweep[0].allFinite() && step.sweep[1].allFinite());
    }
  }
}

TEST(MotionHard, ATowerOfTwentyStands) {
  std::vector<motion::MovingBody> bodies = {floor_body()};
  for (int k = 0; k < 20; ++k) {
    bodies.push_back(at(box_body({0.05, 0.05, 0.025}), {0, 0, 0.0125 + 0.025 * k}));
  }
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(60));
  expect_finite(motion);
  EXPECT_LE(energy_growth(motion), 0.01);
  for (std::size_t k = 1; k < bodies.size(); ++k) {
    const auto moved = [&](std::size_t b) {
      return Vec3(motion.states.back()[b].pose.origin - bodies[b].start.pose.origin);
    };
    EXPECT_LT((moved(k) - moved(k - 1)).norm(), 0.003) << "box " << k;
  }
  // It was put down, not dropped: nothing strikes.
  EXPECT_TRUE(motion.impacts.empty());
}

TEST(MotionHard, ABallInAGrooveComesToRestAtItsBottom) {
  const double radius = 0.02, tilt = 0.7;
  std::vector<motion::MovingBody> bodies = {floor_body(1), floor_body(1), ball_body(radius)};
  for (std::size_t k = 0; k < 2; ++k) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(k == 0 ? tilt : -tilt, Vec3::UnitY()));
    // Slabs whose upper faces meet in the y axis.
    bodies[k].start.pose = {turn, turn * Vec3(k == 0 ? -0.5 : 0.5, 0, -0.05)};
  }
  bodies[2].start.pose.origin = {0.01, 0, 0.1};
  bodies[2].start.velocity = {0, 0.05, 0};
  set_surfaces(bodies, 0.3, 0.4);
  bodies[2].rolling_friction = 1e-4;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(60));
  expect_finite(motion);
  EXPECT_LE(energy_growth(motion), 0.01);
  const motion::BodyState& end = motion.states.back()[2];
  EXPECT_NEAR(end.pose.origin.x(), 0, 1e-4);
  EXPECT_NEAR(end.pose.origin.z(), radius / std::cos(tilt), 1e-4);
  EXPECT_LT(end.velocity.norm(), 1e-3);
}

TEST(MotionHard, WithoutFrictionASlidingBoxNeverStopsNorGains) {
  std::vector<motion::MovingBody> bodies = {floor_body(200),
                                            at(box_body({0.1, 0.06, 0.04}), {0, 0, 0.02})};
  bodies[1].start.velocity = {1, 0, 0};
  set_surfaces(bodies, 0, 0.5);
  motion::MotionOptions options = lasting(60);
  options.world_radius = 1000;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  expect_finite(motion);
  EXPECT_NEAR(motion.states.back()[1].velocity.norm(), 1, 0.01);
  EXPECT_NEAR(motion.states.back()[1].pose.origin.x(), 60, 0.6);
  EXPECT_LE(energy_growth(motion), 0.01);
}

TEST(MotionHard, MassesOneToAMillion) {
  std::vector<motion::MovingBody> bodies = {floor_body(),
                                            at(box_body({0.1, 0.1, 0.1}, 8), {0, 0, 0.05}),
                                            at(box_body({0.1, 0.1, 0.1}, 8e6), {0.02, 0, 0.151})};
  set_surfaces(bodies, 0.5, 0.3);
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(60));
  expect_finite(motion);
  EXPECT_LE(energy_growth(motion), 0.01);
  // A light ball bounces off the heavy box as off a wall.
  std::vector<motion::MovingBody> balls = {at(ball_body(0.05, 1e7), {0, 0, 0}),
                                           at(ball_body(0.01, 10), {0.2, 0, 0})};
  balls[1].start.velocity = {-1, 0, 0};
  set_surfaces(balls, 0, 1);
  motion::MotionOptions options = lasting(0.4);
  options.gravity = Vec3::Zero();
  const motion::Motion bounce = motion::simulate_motion(balls, {}, options);
  EXPECT_NEAR(bounce.states.back()[1].velocity.x(), 1, 1e-3);
}

TEST(MotionHard, AThousandContactsInAFrame) {
  std::vector<motion::MovingBody> bodies = {floor_body(3)};
  // 16 x 16 boxes on their faces: four contacts each.
  for (int i = 0; i < 256; ++i) {
    bodies.push_back(at(box_body({0.05, 0.05, 0.05}),
                        {-0.8 + 0.1 * (i % 16), -0.8 + 0.1 * static_cast<double>(i / 16), 0.026}));
  }
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(0.2));
  expect_finite(motion);
  EXPECT_LE(energy_growth(motion), 0.01);
  std::size_t maximum = 0;
  for (std::size_t k = 0; k < 200; ++k) {
    std::size_t now = 0;
    for (const motion::LastingContact& contact : motion.contacts) {
      now += contact.first_step <= k && k < contact.first_step + contact.steps.size() ? 1 : 0;
    }
    maximum = std::max(maximum, now);
  }
  EXPECT_GE(maximum, 1000u);
}

TEST(MotionHard, FastAndThinDoesNotPassThrough) {
  const auto thrown = [](double speed, double step) {
    std::vector<motion::MovingBody> bodies = {box_body({1, 1, 0.002}),
                                              box_body({0.04, 0.04, 0.001})};
    bodies[0].fixed = true;
    bodies[1].start.pose.origin = {0.01, 0.02, 0.3};
    bodies[1].start.velocity = {0, 0, -speed};
    set_surfaces(bodies, 0.3, 0.5);
    motion::MotionOptions options = lasting(0.2);
    options.time_step = step;
    return motion::simulate_motion(bodies, {}, options);
  };
  // Where the step cannot be cut finely enough it is said, with the time; a shorter step helps.
  EXPECT_EQ(thrown(30, 1e-3).too_fast, 0.0);
  EXPECT_EQ(thrown(100, 1e-3).too_fast, 0.0);
  for (const auto& [speed, step] : {std::pair(10.0, 1e-3), {30.0, 5e-4}, {100.0, 1e-4}}) {
    const motion::Motion motion = thrown(speed, step);
    expect_finite(motion);
    EXPECT_FALSE(motion.too_fast) << speed;
    EXPECT_GT(motion.max_substeps, 1) << speed;
    EXPECT_FALSE(motion.impacts.empty()) << speed;
    for (const auto& states : motion.states) ASSERT_GT(states[1].pose.origin.z(), 0) << speed;
    EXPECT_LE(energy_growth(motion), 0.01) << speed;
  }
}

TEST(MotionHard, ABodyThatLeavesTheWorldIsLeftAlone) {
  std::vector<motion::MovingBody> bodies = {ball_body(0.02), at(ball_body(0.02), {0, 0, 1})};
  motion::MotionOptions options = lasting(60);
  options.world_radius = 20;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  expect_finite(motion);
  const double expected = std::sqrt(2 * 20 / gravity);
  EXPECT_NEAR(motion.left[0], expected, 0.01);
  EXPECT_NEAR(motion.states.back()[0].pose.origin.z(), -20, 0.1);
  EXPECT_LE(energy_growth(motion), 0.01);
}

TEST(MotionHard, BallsThatBounceForAMinuteGainNothing) {
  std::vector<motion::MovingBody> bodies = {floor_body()};
  for (int k = 0; k < 5; ++k)
    bodies.push_back(at(ball_body(0.02), {0.2 * k - 0.4, 0, 0.1 + 0.2 * k}));
  set_surfaces(bodies, 0.3, 1);
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(60));
  expect_finite(motion);
  EXPECT_LE(energy_growth(motion), 0.01);
}

TEST(MotionHard, AHeapOfBoxesComesToRest) {
  std::vector<motion::MovingBody> bodies = {floor_body()};
  for (int k = 0; k < 20; ++k) {
    motion::MovingBody box =
        at(box_body({0.06, 0.04, 0.03}),
           {0.02 * ((k * 7) % 5 - 2), 0.02 * ((k * 3) % 5 - 2), 0.05 + 0.06 * k});
    box.start.pose.turn = Eigen::Quaterniond(
        Eigen::AngleAxisd(0.7 * k, Vec3(0.3 * (k % 3), 1, 0.2 * k).normalized()));
    bodies.push_back(box);
  }
  set_surfaces(bodies, 0.5, 0.3);
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(60));
  expect_finite(motion);
  EXPECT_LE(energy_growth(motion), 0.01);
  for (std::size_t k = 1; k < bodies.size(); ++k) {
    EXPECT_LT(motion.states.back()[k].velocity.norm(), 0.02) << k;
    EXPECT_GT(motion.states.back()[k].pose.origin.z(), 0.01) << k;
  }
}

/// Three balls and two boxes thrown onto a textured floor with walls around it.
std::vector<motion::MovingBody> balls_on(const render::maps::SurfaceMap& map) {
  std::vector<motion::MovingBody> bodies = {textured_floor(map, 1)};
  for (int k = 0; k < 4; ++k) {
    motion::MovingBody wall = box_body(k < 2 ? Vec3(0.1, 1.2, 0.6) : Vec3(1.2, 0.1, 0.6));
    wall.fixed = true;
    const double place = k % 2 == 0 ? 0.55 : -0.55;
    wall.start.pose.origin = k < 2 ? Vec3(place, 0, 0.3) : Vec3(0, place, 0.3);
    bodies.push_back(wall);
  }
  for (int k = 0; k < 3; ++k) {
    motion::MovingBody ball = at(ball_body(0.015), {0.15 * k - 0.2, 0.1 * k - 0.1, 0.1});
    ball.start.velocity = {0.5 - 0.4 * k, 0.3, 0};
    bodies.push_back(ball);
  }
  for (int k = 0; k < 2; ++k) {
    motion::MovingBody box = at(box_body({0.06, 0.04, 0.03}), {0.2 * k, -0.3, 0.08 + 0.1 * k});
    box.start.pose.turn =
        Eigen::Quaterniond(Eigen::AngleAxisd(0.7 + k, Vec3(1, 2, 3).normalized()));
    box.start.velocity = {0.4 - 0.8 * k, 0.5, 0};
    bodies.push_back(box);
  }
  set_surfaces(bodies, 0.4, 0.5);
  return bodies;
}

TEST(MotionHard, AMinuteOnABrickRelief) {
  const std::vector<motion::MovingBody> bodies =
      balls_on(render::maps::generate_map("brick", {}, 512, 3));
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(60));
  expect_finite(motion);
  EXPECT_LE(energy_growth(motion), 0.01);
  for (std::size_t b = 5; b < bodies.size(); ++b) {
    EXPECT_GT(motion.states.back()[b].pose.origin.z(), 0.015 - 0.005);
  }
}

TEST(MotionHard, AMinuteOnAVerticalEdge) {
  // A step of 5 mm between two texels, all along v.
  render::maps::SurfaceMap map;
  map.name = "edge";
  map.width = map.height = 200;
  map.texel = 5e-4;
  for (int k = 0; k < 200 * 200; ++k) map.heights.push_back(k % 200 < 100 ? 0.0f : -0.005f);
  const std::vector<motion::MovingBody> bodies = balls_on(map);
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(60));
  expect_finite(motion);
  EXPECT_LE(energy_growth(motion), 0.01);
  // At all times above the surface that a ball can reach, but for the way of a step: never in the
  // map's step.
  const render::maps::SurfaceMap traced = render::maps::traced_map(map, 0.015);
  for (std::size_t k = 0; k < motion.states.size(); ++k) {
    for (std::size_t b = 5; b < 8; ++b) {
      const Vec3 centre = motion.states[k][b].pose.origin;
      const double lowest =
          render::maps::height_at(traced, {centre.x() + 0.5, centre.y() + 0.5}) + 0.015;
      const double a_step = motion.states[k][b].velocity.norm() * motion.step;
      ASSERT_GT(centre.z(), lowest - 3e-4 - a_step) << b << " at " << k;
    }
  }
}

/// A tile whose upper face is a relief.
motion::MovingBody relief_tile(const render::maps::SurfaceMap& map) {
  motion::MovingBody tile = box_body({0.1, 0.1, 0.02});
  render::maps::TexturedFace face;
  face.map = std::make_shared<const render::maps::SurfaceMap>(map);
  face.origin = {-0.05, -0.05, 0.01};
  face.size = {0.1, 0.1};
  tile.texture = face;
  return tile;
}

// A relief is met on its face alone, whatever side of its body is touched.
TEST(MotionHard, ABallFromBelowDoesNotPassAReliefsBody) {
  std::vector<motion::MovingBody> bodies = {
      relief_tile(render::maps::generate_map("pebbles", {}, 128, 1)),
      at(ball_body(0.01), {0.01, 0.02, -0.1})};
  bodies[0].fixed = true;
  bodies[1].start.velocity = {0, 0, 2};
  set_surfaces(bodies, 0.4, 0.5);
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(1));
  EXPECT_FALSE(motion.impacts.empty());
  for (const auto& states : motion.states)
    ASSERT_LT(states[1].pose.origin.z(), -0.0175);  // a step of 2 mm
  EXPECT_LE(energy_growth(motion), 0.01);
}

TEST(MotionHard, TilesWithReliefsFallOnOneAnother) {
  const render::maps::SurfaceMap map =
      render::maps::generate_map("grooves", {{"wavelength", 0.01}, {"depth", 0.002}}, 128, 1);
  std::vector<motion::MovingBody> bodies = {floor_body()};
  for (int k = 0; k < 3; ++k) {
    motion::MovingBody tile = at(relief_tile(map), {0.004 * k, 0.003 * k, 0.03 + 0.04 * k});
    bodies.push_back(tile);
  }
  set_surfaces(bodies, 0.5, 0.3);
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(5));
  expect_finite(motion);
  EXPECT_LE(energy_growth(motion), 0.01);
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    EXPECT_LT(motion.states.back()[b].velocity.norm(), 0.05) << b;
    EXPECT_GT(motion.states.back()[b].pose.origin.z(), 0.009) << b;
  }
}

/// Kinetic energy, that of height, and what the map's integrated height would hold.
double energy_on_map(const std::vector<motion::MovingBody>& bodies, const motion::Motion& motion,
                     std::size_t k, const render::maps::SurfaceMap& relief) {
  double energy = motion.energy[k];
  for (std::size_t b = 5; b < bodies.size(); ++b) {
    const Vec3 place = motion.states[k][b].pose.origin;
    energy += bodies[b].rigid.mass * gravity *
              render::maps::height_at(relief, {place.x() + 0.5, place.y() + 0.5});
  }
  return energy;
}

TEST(MotionHard, AMinuteOnANormalMap) {
  const render::maps::SurfaceMap relief = render::maps::generate_map("pebbles", {}, 256, 5);
  const render::maps::SurfaceMap map = render::maps::normal_map_of(relief);
  const render::maps::SurfaceMap integrated = render::maps::integrated_relief(map);
  const std::vector<motion::MovingBody> bodies = balls_on(map);
  const motion::Motion motion = motion::simulate_motion(bodies, {}, lasting(60));
  expect_finite(motion);
  const double start = energy_on_map(bodies, motion, 0, integrated);
  double highest = start, lowest = start;
  for (std::size_t k = 0; k < motion.states.size(); ++k) {
    const double energy = energy_on_map(bodies, motion, k, integrated);
    highest = std::max(highest, energy);
    lowest = std::min(lowest, energy);
  }
  EXPECT_LE(highest - start, 0.01 * (start - lowest));
}

TEST(MotionHard, WhatCannotMoveIsRefused) {
  const auto message = [](std::vector<motion::MovingBody> bodies,
                          motion::MotionOptions options = {}) {
    try {
      motion::simulate_motion(bodies, {}, options);
    } catch (const core::Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  motion::MovingBody body = box_body({0.1, 0.1, 0.1});
  body.name = "plate-000";
  body.start.velocity.x() = std::nan("");
  EXPECT_NE(message({body}).find("plate-000"), std::string::npos);
  body = box_body({0.1, 0.1, 0.1});
  body.restitution = 1.5;
  EXPECT_NE(message({body}).find("restitution"), std::string::npos);
  body = box_body({0.1, 0.1, 0.1});
  body.hulls = {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0)}};
  EXPECT_NE(message({body}).find("no volume"), std::string::npos);
  motion::MotionOptions options;
  options.time_step = 0;
  EXPECT_NE(message({box_body({0.1, 0.1, 0.1})}, options).find("step"), std::string::npos);
}

}  // namespace
}  // namespace carillon::synth
