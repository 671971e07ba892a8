// Motion on textured faces: closed forms, and the surface as a ball traces it.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "solvers/textures/generated_maps.hpp"
#include "synth/motion/relief_contacts.hpp"
#include "tests/synth/moving_bodies.hpp"

namespace carillon::synth {
namespace {

constexpr double kGravity = 9.80665;

solvers::SurfaceMap flat_relief(double depth) {
  solvers::SurfaceMap map;
  map.name = "flat";
  map.width = map.height = 16;
  map.texel = 1e-3;
  map.heights.assign(256, static_cast<float>(-depth));
  return map;
}

solvers::SurfaceMap sloping_normals(double slope) {
  solvers::SurfaceMap map;
  map.name = "slope";
  map.width = map.height = 16;
  map.texel = 1e-3;
  map.slopes_u.assign(256, static_cast<float>(slope));
  map.slopes_v.assign(256, 0);
  return map;
}

TEST(ReliefContacts, ABallOnAFlatReliefTouchesBelowItsCentre) {
  const solvers::SurfaceMap map = flat_relief(0.002);
  const std::vector<ReliefContact> found =
      ball_on_relief(map, {1, 1}, {0.5003, 0.5001, 0.0079}, 0.01);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].depth, 0.0001, 1e-9);
  EXPECT_NEAR((found[0].point - Vec3(0.5003, 0.5001, -0.0021)).norm(), 0, 1e-7);
  EXPECT_NEAR((found[0].normal - Vec3::UnitZ()).norm(), 0, 1e-6);
  EXPECT_TRUE(ball_on_relief(map, {1, 1}, {0.5, 0.5, 0.0081}, 0.01).empty());
  EXPECT_TRUE(ball_on_relief(map, {1, 1}, {1.5, 0.5, 0.005}, 0.01).empty());
}

// Where ball and relief touch their slopes agree, and a ball across a groove touches both sides.
TEST(ReliefContacts, ABallInAGrooveTouchesBothSides) {
  const double wave = 0.016, depth = 0.004, radius = 0.01;
  const solvers::SurfaceMap map = solvers::generate_map(
      "grooves", {{"wavelength", wave}, {"depth", depth}, {"waves", 8}}, 512, 0);
  // Above the bottom of a groove, 0.1 mm deeper than a ball at rest would be.
  double bottom = wave / 2;
  for (double u = wave / 2; u < 1.5 * wave; u += wave / 400) {
    if (solvers::height_at(map, {u, 0.01}) < solvers::height_at(map, {bottom, 0.01})) bottom = u;
  }
  const Eigen::Vector2d place(bottom, 0.01);
  const double rest = solvers::traced_height(map, place, radius) + radius;
  const std::vector<ReliefContact> found =
      ball_on_relief(map, {1, 1}, {place.x(), place.y(), rest - 1e-4}, radius);
  ASSERT_EQ(found.size(), 2u);
  const Vec3 centre(place.x(), place.y(), rest - 1e-4);
  for (const ReliefContact& contact : found) {
    const Vec3 of_ball = (centre - contact.point) / radius;
    EXPECT_NEAR((of_ball - contact.normal).norm(), 0, 1e-3);
    EXPECT_NEAR(contact.depth / contact.normal.z(), 1e-4, 2e-6);
  }
  EXPECT_NEAR(found[0].point.x() + found[1].point.x(), 2 * bottom, 1e-4);
}

TEST(ReliefContacts, AFlatBoxTouchesFarApart) {
  const solvers::SurfaceMap map = flat_relief(0.001);
  const MovingBody box = box_body({0.04, 0.03, 0.02});
  std::vector<Vec3> points;
  for (const Vec3& p : box.hulls[0]) points.push_back(p + Vec3(0.5, 0.5, 0.01 - 0.0011));
  const std::vector<std::int32_t> bottom = {0, 2, 1, 1, 2, 3};  // seen from below
  const std::vector<ReliefContact> found = hull_on_relief(map, {1, 1}, points, bottom);
  ASSERT_EQ(found.size(), kMostReliefContacts);
  Eigen::Vector2d low(1, 1), high(0, 0);
  for (const ReliefContact& contact : found) {
    EXPECT_NEAR(contact.depth, 1e-4, 1e-9);
    low = low.cwiseMin(contact.point.head<2>());
    high = high.cwiseMax(contact.point.head<2>());
  }
  EXPECT_GT(high.x() - low.x(), 0.035);
  EXPECT_GT(high.y() - low.y(), 0.025);
}

// A ball laid on a relief rolls as if its centre followed the surface that its radius traces.
TEST(TexturedMotion, ABallFollowsTheTracedRelief) {
  const double radius = 0.01;
  const solvers::SurfaceMap map = solvers::generate_map(
      "grooves", {{"wavelength", 0.04}, {"depth", 0.003}, {"waves", 8}}, 512, 0);
  std::vector<MovingBody> bodies = {textured_floor(map, 1), ball_body(radius)};
  const double start = solvers::traced_height(map, {0.1, 0.5}, radius);
  bodies[1].start.pose.origin = {-0.4, 0, start + radius};
  bodies[1].start.velocity = {0.5, 0, 0};
  bodies[1].start.spin = {0, 0.5 / radius, 0};
  set_surfaces(bodies, 0.8, 0);
  MotionOptions options;
  options.seconds = 1;
  const Motion motion = simulate_motion(bodies, {}, options);
  for (std::size_t k = 100; k < motion.states.size(); k += 50) {
    const Vec3 centre = motion.states[k][1].pose.origin;
    const double height =
        solvers::traced_height(map, {centre.x() + 0.5, centre.y() + 0.5}, radius) + radius;
    EXPECT_NEAR(centre.z(), height, 2e-4) << k;
  }
  EXPECT_GT(motion.states.back()[1].pose.origin.x(), -0.2);
  EXPECT_LE(energy_growth(motion), 0.01);
}

// Without friction a map of slope s on a flat floor drives a ball as a slope does: a = g s / (1 +
// s^2) along the floor, as the normal alone is replaced.
TEST(TexturedMotion, NormalsOfASlopeDriveABall) {
  const double slope = 0.1;
  std::vector<MovingBody> bodies = {textured_floor(sloping_normals(slope)),
                                    at(ball_body(0.02), {1, 0, 0.02})};
  set_surfaces(bodies, 0, 0);
  MotionOptions options;
  options.seconds = 0.5;
  const Motion motion = simulate_motion(bodies, {}, options);
  const double expected = kGravity * slope / (1 + slope * slope) / 8;
  EXPECT_NEAR(1 - motion.states.back()[1].pose.origin.x(), expected, 0.02 * expected);
  // Equation 5.2: the push goes through the centre, so that nothing turns the ball.
  EXPECT_LT(motion.states.back()[1].spin.norm(), 1e-6);
}

TEST(TexturedMotion, AFlatMapChangesNothing) {
  for (const bool relief : {false, true}) {
    std::vector<MovingBody> plain = {floor_body(), at(ball_body(0.02), {0, 0, 0.1})};
    plain[1].start.velocity = {0.3, 0.1, 0};
    std::vector<MovingBody> textured = plain;
    textured[0] = textured_floor(relief ? flat_relief(0) : sloping_normals(0));
    MotionOptions options;
    options.seconds = 0.7;
    const Motion a = simulate_motion(plain, {}, options);
    const Motion b = simulate_motion(textured, {}, options);
    EXPECT_EQ(a.impacts.size(), b.impacts.size());
    EXPECT_NEAR((a.states.back()[1].pose.origin - b.states.back()[1].pose.origin).norm(), 0, 1e-3)
        << relief;
  }
}

}  // namespace
}  // namespace carillon::synth
