// Motion on textured faces: closed forms, and the surface as a ball traces it.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/maps/generated_maps.hpp"
#include "tests/synth/moving_bodies.hpp"

namespace carillon::synth {
namespace {

constexpr double gravity = 9.80665;

render::maps::SurfaceMap sloping_normals(double slope) {
  render::maps::SurfaceMap map;
  map.name = "slope";
  map.width = map.height = 16;
  map.texel = 1e-3;
  map.slopes_u.assign(256, static_cast<float>(slope));
  map.slopes_v.assign(256, 0);
  return map;
}

// A ball laid on a relief rolls as if its centre followed the surface that its radius traces.
TEST(TexturedMotion, ABallFollowsTheTracedRelief) {
  const double radius = 0.01;
  const render::maps::SurfaceMap map = render::maps::generate_map(
      "grooves", {{"wavelength", 0.04}, {"depth", 0.003}, {"waves", 8}}, 512, 0);
  std::vector<motion::MovingBody> bodies = {textured_floor(map, 1), ball_body(radius)};
  const double start = render::maps::traced_height(map, {0.1, 0.5}, radius);
  bodies[1].start.pose.origin = {-0.4, 0, start + radius};
  bodies[1].start.velocity = {0.5, 0, 0};
  bodies[1].start.spin = {0, 0.5 / radius, 0};
  set_surfaces(bodies, 0.8, 0);
  motion::MotionOptions options;
  options.seconds = 1;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  for (std::size_t k = 100; k < motion.states.size(); k += 50) {
    const Vec3 centre = motion.states[k][1].pose.origin;
    const double height =
        render::maps::traced_height(map, {centre.x() + 0.5, centre.y() + 0.5}, radius) + radius;
    EXPECT_NEAR(centre.z(), height, 2e-4) << k;
  }
  EXPECT_GT(motion.states.back()[1].pose.origin.x(), -0.2);
  EXPECT_LE(energy_growth(motion), 0.01);
}

// Without friction a map of slope s on a flat floor drives a ball as a slope does: a = g s / (1 +
// s^2) along the floor, as the normal alone is replaced.
TEST(TexturedMotion, NormalsOfASlopeDriveABall) {
  const double slope = 0.1;
  std::vector<motion::MovingBody> bodies = {textured_floor(sloping_normals(slope)),
                                            at(ball_body(0.02), {1, 0, 0.02})};
  set_surfaces(bodies, 0, 0);
  motion::MotionOptions options;
  options.seconds = 0.5;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  const double expected = gravity * slope / (1 + slope * slope) / 8;
  EXPECT_NEAR(1 - motion.states.back()[1].pose.origin.x(), expected, 0.02 * expected);
  // Equation 5.2: the push goes through the centre, so that nothing turns the ball.
  EXPECT_LT(motion.states.back()[1].spin.norm(), 1e-6);
}

TEST(TexturedMotion, AFlatMapChangesNothing) {
  for (const bool relief : {false, true}) {
    std::vector<motion::MovingBody> plain = {floor_body(), at(ball_body(0.02), {0, 0, 0.1})};
    plain[1].start.velocity = {0.3, 0.1, 0};
    std::vector<motion::MovingBody> textured = plain;
    textured[0] = textured_floor(relief ? flat_relief(0) : sloping_normals(0));
    motion::MotionOptions options;
    options.seconds = 0.7;
    const motion::Motion a = motion::simulate_motion(plain, {}, options);
    const motion::Motion b = motion::simulate_motion(textured, {}, options);
    EXPECT_EQ(a.impacts.size(), b.impacts.size());
    EXPECT_NEAR((a.states.back()[1].pose.origin - b.states.back()[1].pose.origin).norm(), 0, 1e-3)
        << relief;
  }
}

}  // namespace
}  // namespace carillon::synth
