// Motion against closed forms of mechanics.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "tests/synth/moving_bodies.hpp"

namespace carillon::synth {
namespace {

constexpr double gravity = 9.80665;

TEST(Motion, FreeFallIsThatOfGalileo) {
  const std::vector<motion::MovingBody> bodies = {at(ball_body(0.02), {0, 0, 10})};
  motion::MotionOptions options;
  options.seconds = 1;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  ASSERT_EQ(motion.states.size(), 1001u);
  for (const std::size_t k : {100u, 500u, 1000u}) {
    const double t = 1e-3 * static_cast<double>(k);
    // Half a step early, as the integrator is of first order.
    EXPECT_NEAR(motion.states[k][0].pose.origin.z(), 10 - gravity * t * t / 2,
                0.51 * gravity * t * options.time_step);
  }
  EXPECT_TRUE(motion.impacts.empty());
  EXPECT_TRUE(motion.contacts.empty());
}

TEST(Motion, AThrownBallFliesAParabolaAndSpinStays) {
  std::vector<motion::MovingBody> bodies = {ball_body(0.02)};
  bodies[0].start.velocity = {3, -1, 4};
  bodies[0].start.spin = {1, 20, -5};
  motion::MotionOptions options;
  options.seconds = 0.5;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  const motion::BodyState& end = motion.states.back()[0];
  EXPECT_NEAR(end.pose.origin.x(), 1.5, 1e-9);
  EXPECT_NEAR(end.pose.origin.y(), -0.5, 1e-9);
  EXPECT_NEAR(end.pose.origin.z(), 2 - gravity / 8, 0.003);
  EXPECT_NEAR((end.spin - Vec3(1, 20, -5)).norm(), 0, 1e-9);
}

// Heights of rebounds are e^2 of one another, impacts come when they must, and their impulse is
// m v (1 + e).
TEST(Motion, ABouncingBallLosesWhatRestitutionTakes) {
  for (const double e : {0.5, 0.8, 1.0}) {
    std::vector<motion::MovingBody> bodies = {floor_body(), at(ball_body(0.02), {0, 0, 0.52})};
    set_surfaces(bodies, 0.3, e);
    motion::MotionOptions options;
    options.seconds = 1.2;
    const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
    ASSERT_GE(motion.impacts.size(), 2u) << e;
    const double speed = std::sqrt(2 * gravity * 0.5);
    const motion::Impact& first = motion.impacts[0];
    EXPECT_NEAR(first.time, speed / gravity, 0.6 * options.time_step);
    EXPECT_NEAR(first.speed, speed, 1e-3 * speed);
    EXPECT_NEAR(first.impulse.norm(), bodies[1].rigid.mass * speed * (1 + e), 2e-3 * speed);
    EXPECT_NEAR(first.impulse.normalized().z(), -1, 1e-9);  // on the first body, the floor
    const motion::Impact& second = motion.impacts[1];
    EXPECT_NEAR(second.time - first.time, 2 * e * speed / gravity, 2 * options.time_step) << e;
    EXPECT_NEAR(second.speed, e * speed, 5e-3 * speed) << e;
  }
}

TEST(Motion, HertzGivesTheContactTime) {
  std::vector<motion::MovingBody> bodies = {floor_body(), at(ball_body(0.01), {0, 0, 0.06})};
  bodies[0].curvature = 0;
  motion::MotionOptions options;
  options.seconds = 0.2;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  ASSERT_GE(motion.impacts.size(), 1u);
  // Johnson 1985, eq. 11.24, both bodies of glass: E* = E / (2 (1 - nu^2)).
  const double modulus = 7e10 / (2 * (1 - 0.04)), mass = bodies[1].rigid.mass;
  const double speed = std::sqrt(2 * gravity * 0.05);
  const double expected = 2.8683 * std::pow(mass * mass / (0.01 * modulus * modulus * speed), 0.2);
  EXPECT_NEAR(motion.impacts[0].duration, expected, 2e-3 * expected);
}

// a = g (sin(theta) - mu cos(theta)), or none where friction holds it.
TEST(Motion, ABoxSlidesDownASlopeAsCoulombSays) {
  const double theta = 0.4;
  for (const double mu : {0.0, 0.2, 0.6}) {
    std::vector<motion::MovingBody> bodies = {floor_body(20), box_body({0.1, 0.08, 0.05})};
    const Eigen::Quaterniond tilt(Eigen::AngleAxisd(theta, Vec3::UnitY()));
    bodies[0].start.pose = {tilt, tilt * Vec3(0, 0, -0.05)};
    bodies[1].start.pose = {tilt, tilt * Vec3(0, 0, 0.025)};
    set_surfaces(bodies, mu, 0);
    motion::MotionOptions options;
    options.seconds = 0.5;
    const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
    const double way = (motion.states.back()[1].pose.origin - bodies[1].start.pose.origin).norm();
    const double acceleration = std::max(0.0, gravity * (std::sin(theta) - mu * std::cos(theta)));
    EXPECT_NEAR(way, acceleration / 8, 0.01 * acceleration / 8 + 2e-4) << mu;
  }
}

// A ball that rolls without slipping: a = 5/7 g sin(theta).
TEST(Motion, ABallRollsDownASlope) {
  const double theta = 0.2, radius = 0.02;
  std::vector<motion::MovingBody> bodies = {floor_body(20), ball_body(radius)};
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(theta, Vec3::UnitY()));
  bodies[0].start.pose = {tilt, tilt * Vec3(0, 0, -0.05)};
  bodies[1].start.pose.origin = tilt * Vec3(0, 0, radius);
  set_surfaces(bodies, 0.8, 0);
  motion::MotionOptions options;
  options.seconds = 0.6;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  const motion::BodyState& end = motion.states.back()[1];
  const double way = (end.pose.origin - bodies[1].start.pose.origin).norm();
  const double expected = 5.0 / 7 * gravity * std::sin(theta) * 0.18;
  EXPECT_NEAR(way, expected, 0.01 * expected);
  EXPECT_NEAR(end.spin.norm() * radius, end.velocity.norm(), 0.01 * end.velocity.norm());
  ASSERT_EQ(motion.contacts.size(), 1u);
  const motion::ContactStep& step = motion.contacts[0].steps[400];
  EXPECT_LT(step.slip.norm(), 0.01 * end.velocity.norm());
  // The place of contact moves alike over floor and ball.
  EXPECT_NEAR((step.sweep[0] - step.sweep[1]).norm(), 0, 0.05 * step.sweep[0].norm());
  const double speed = motion.states[motion.contacts[0].first_step + 401][1].velocity.norm();
  EXPECT_NEAR(step.sweep[0].norm(), speed, 0.02 * speed);
  double mean = 0;
  // The normal points from the second body, the ball, into the floor, and pushes apart.
  EXPECT_LT(step.normal.z(), 0);
  for (const motion::ContactStep& one : motion.contacts[0].steps) mean += one.force.dot(one.normal);
  mean /= static_cast<double>(motion.contacts[0].steps.size());
  const double weight = bodies[1].rigid.mass * gravity * std::cos(theta);
  EXPECT_NEAR(mean, weight, 0.02 * weight);
}

TEST(Motion, TwoBallsExchangeTheirMotion) {
  std::vector<motion::MovingBody> bodies = {at(ball_body(0.02), {0, 0, 0}),
                                            at(ball_body(0.02), {0.1, 0, 0})};
  bodies[0].start.velocity = {2, 0, 0};
  set_surfaces(bodies, 0, 1);
  motion::MotionOptions options;
  options.seconds = 0.1;
  options.gravity = Vec3::Zero();
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  EXPECT_NEAR(motion.states.back()[0].velocity.x(), 0, 1e-6);
  EXPECT_NEAR(motion.states.back()[1].velocity.x(), 2, 1e-6);
  ASSERT_EQ(motion.impacts.size(), 1u);
  EXPECT_NEAR(motion.impacts[0].time, 0.03, 1e-9);
  EXPECT_NEAR(motion.impacts[0].impulse.x(), -2 * bodies[0].rigid.mass, 1e-9);
  EXPECT_NEAR((motion.impacts[0].points[0] - Vec3(0.02, 0, 0)).norm(), 0, 2.1e-3);
}

// A torque-free brick turns about its middle axis and tumbles; energy and angular momentum stay.
TEST(Motion, AFreeBrickKeepsItsAngularMomentum) {
  std::vector<motion::MovingBody> bodies = {box_body({0.1, 0.06, 0.02})};
  bodies[0].start.spin = {0.1, 10, 0.1};
  motion::MotionOptions options;
  options.seconds = 2;
  options.gravity = Vec3::Zero();
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  const auto momentum = [&](const motion::BodyState& state) {
    const Vec3 local = state.pose.turn.conjugate() * state.spin;
    return Vec3(state.pose.turn * bodies[0].rigid.inertia.cwiseProduct(local));
  };
  const Vec3 before = momentum(motion.states.front()[0]), after = momentum(motion.states.back()[0]);
  EXPECT_NEAR((after - before).norm(), 0, 0.05 * before.norm());
  EXPECT_LE(energy_growth(motion), 0.01 * motion.energy.front());
}

// Small swings: T = 2 pi sqrt(l / g) for a small ball on a string.
TEST(Motion, APendulumOnAStringKeepsTime) {
  std::vector<motion::MovingBody> bodies = {ball_body(0.005)};
  const double length = 0.5, angle = 0.05;
  bodies[0].start.pose.origin = {length * std::sin(angle), 0, -length * std::cos(angle)};
  const std::vector<motion::MotionString> strings = {{0, Vec3::Zero(), Vec3::Zero(), 0}};
  motion::MotionOptions options;
  options.seconds = 5;
  const motion::Motion motion = motion::simulate_motion(bodies, strings, options);
  std::vector<double> crossings;
  for (std::size_t k = 1; k < motion.states.size(); ++k) {
    const double a = motion.states[k - 1][0].pose.origin.x(),
                 b = motion.states[k][0].pose.origin.x();
    if (a > 0 && b <= 0)
      crossings.push_back(options.time_step * (static_cast<double>(k) - b / (b - a)));
  }
  ASSERT_GE(crossings.size(), 3u);
  const double period =
      (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  EXPECT_NEAR(period, 2 * std::numbers::pi * std::sqrt(length / gravity), 3e-3 * period);
  double tension = 0;
  for (const auto& step : motion.tensions) tension += step[0];
  tension /= static_cast<double>(motion.tensions.size());
  EXPECT_NEAR(tension, bodies[0].rigid.mass * gravity, 0.01 * tension);
  for (const auto& states : motion.states) {
    EXPECT_LT(states[0].pose.origin.norm(), length * 1.001);
  }
}

// Held bodies stay, and bear others, until they are let go with the motion of their start.
TEST(Motion, AHeldBodyIsLetGoInTime) {
  std::vector<motion::MovingBody> bodies = {at(box_body({0.1, 0.1, 0.1}), {0, 0, 0}),
                                            at(ball_body(0.01), {0, 0, 0.06})};
  bodies[0].release = 0.5;
  bodies[0].start.velocity = {1, 0, 0};
  motion::MotionOptions options;
  options.seconds = 1;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  EXPECT_EQ(motion.states[500][0].pose.origin, Vec3(0, 0, 0));
  EXPECT_EQ(motion.states[500][0].velocity, Vec3(0, 0, 0));
  EXPECT_NEAR(motion.states[500][1].pose.origin.z(), 0.06, 1e-4);
  EXPECT_NEAR(motion.states[1000][0].pose.origin.x(), 0.5, 1e-3);
  EXPECT_NEAR(motion.states[1000][0].pose.origin.z(), -gravity / 8, 0.01);
}

TEST(Motion, BodiesInOneAnotherAtTheStartAreTold) {
  std::vector<motion::MovingBody> bodies = {floor_body(), at(ball_body(0.02), {0, 0, 0.01}),
                                            at(ball_body(0.02), {0.5, 0, 0.02}),
                                            at(box_body({0.1, 0.1, 0.1}), {1, 0, 0.05})};
  motion::MotionOptions options;
  options.seconds = 0.01;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  // The floor's upper side is at 0: one ball is in it by a half of its radius, the others rest.
  ASSERT_EQ(motion.overlaps.size(), 1u);
  EXPECT_EQ(motion.overlaps[0].bodies, (std::array<std::size_t, 2>{0, 1}));
  EXPECT_NEAR(motion.overlaps[0].depth, 0.01, 1e-6);
}

TEST(Motion, EndsWhenItsTimeIsUp) {
  std::vector<motion::MovingBody> bodies = {at(ball_body(0.02), {0, 0, 10})};
  motion::MotionOptions options;
  options.seconds = 1000;
  options.limit = {1e-3, "a simulation", "limits.sample_time"};
  EXPECT_THROW(motion::simulate_motion(bodies, {}, options), core::TimeError);
}

TEST(Motion, SameInputSameBits) {
  std::vector<motion::MovingBody> bodies = {floor_body()};
  for (int k = 0; k < 6; ++k) {
    bodies.push_back(at(box_body({0.04, 0.03, 0.02}), {0.003 * k, 0.002 * k, 0.05 + 0.04 * k}));
  }
  motion::MotionOptions options;
  options.seconds = 0.6;
  const motion::Motion a = motion::simulate_motion(bodies, {}, options),
                       b = motion::simulate_motion(bodies, {}, options);
  ASSERT_EQ(a.impacts.size(), b.impacts.size());
  EXPECT_GT(a.impacts.size(), 6u);
  for (std::size_t k = 0; k < a.impacts.size(); ++k) {
    EXPECT_EQ(a.impacts[k].time, b.impacts[k].time);
    EXPECT_EQ(a.impacts[k].impulse, b.impacts[k].impulse);
  }
  for (std::size_t s = 0; s < bodies.size(); ++s) {
    EXPECT_EQ(a.states.back()[s].pose.origin, b.states.back()[s].pose.origin);
    EXPECT_EQ(a.states.back()[s].pose.turn.coeffs(), b.states.back()[s].pose.turn.coeffs());
  }
}

// A box that stands on the floor is borne by it: forces sum to its weight, and nothing strikes.
TEST(Motion, ARestingBoxIsBorneByItsWeight) {
  std::vector<motion::MovingBody> bodies = {floor_body(),
                                            at(box_body({0.1, 0.1, 0.1}), {0, 0, 0.05})};
  motion::MotionOptions options;
  options.seconds = 1;
  const motion::Motion motion = motion::simulate_motion(bodies, {}, options);
  EXPECT_TRUE(motion.impacts.empty());
  ASSERT_FALSE(motion.contacts.empty());
  Vec3 sum = Vec3::Zero();
  for (const motion::LastingContact& contact : motion.contacts) {
    for (const motion::ContactStep& step : contact.steps) sum += step.force;
  }
  sum /= 1000;
  const double weight = bodies[1].rigid.mass * gravity;
  EXPECT_NEAR(sum.z(), -weight, 0.01 * weight);
  EXPECT_NEAR(motion.states.back()[1].pose.origin.z(), 0.05, 1e-4);
}

}  // namespace
}  // namespace carillon::synth
