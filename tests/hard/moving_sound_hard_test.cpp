// Sound of moving bodies where it is hard: what is NaN, endless, huge, far away or all at once.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "../synth/radiators.hpp"
#include "../synth/scraped_face.hpp"
#include "core/error.hpp"
#include "synth/motion/motion_sound.hpp"

namespace carillon::synth {
namespace {

struct Ball {
  solvers::modes::Modes modes =
      sphere_modes(curved_sphere(0.05, Vec3::Zero(), 4, 3), 0.05, 1, {0.5, 1, 2});
  radiation::SourceField field{
      radiation::fit_equivalent_sources(modes, {.min_sources = 100, .max_sources = 100})};
  motion::SoundingBody body() const {
    motion::SoundingBody body;
    body.modes = &modes;
    body.field = &field;
    body.decay_rates.assign(modes.size(), 10);
    body.rests = {"felt", 0.5, 0.3, ""};
    body.click = contact::rigid_source(modes.surface, 0.3);
    return body;
  }
};

const std::vector<modal::Listener> listeners = {{{1, 0.5, 0.8}}};

double peak(const motion::MotionSound& sound) {
  double largest = 0;
  for (const float sample : sound.samples) {
    EXPECT_TRUE(std::isfinite(sample));
    largest = std::max(largest, std::abs(static_cast<double>(sample)));
  }
  return largest;
}

/// Over the ball's top instead of beside it, where a force along z moves no radial mode.
void scrape_over_the_top(Scrape& scene) {
  const Vec3 by(-0.06, -5, 0.05);
  scene.bodies[1].texture->origin += by;
  for (auto& states : scene.motion.states) states[0].pose.origin += by;
  for (motion::ContactStep& step : scene.motion.contacts[0].steps) step.points[1] += by;
}

motion::Impact strike(double time, double impulse, double duration) {
  motion::Impact impact;
  impact.time = time;
  impact.bodies = {0, 1};
  impact.points = {Vec3(0, 0, 0.05), Vec3(0, 0, 0.05)};
  impact.normal = Vec3::UnitZ();
  impact.impulse = Vec3(0, 0, impulse);
  impact.duration = duration;
  return impact;
}

TEST(MovingSoundHard, AThousandContactsAndStrikesInOneStep) {
  const Ball ball;
  Scrape scene(sine_map(2e-3, 1e-6, 32, 4), 0.3, 5, 0.05);
  scrape_over_the_top(scene);
  const std::vector<motion::SoundingBody> bodies = {{}, ball.body()};
  const double of_one =
      peak(motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {}));
  EXPECT_GT(of_one, 0);
  // A thousand share the force of one.
  for (motion::ContactStep& step : scene.motion.contacts[0].steps) step.force /= 1000;
  scene.motion.contacts.resize(1000, scene.motion.contacts[0]);
  const double of_all =
      peak(motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {}));
  EXPECT_NEAR(of_all / of_one, 1, 1e-3);
  for (int i = 0; i < 1000; ++i) scene.motion.impacts.push_back(strike(0.02, 1e-3, 1e-4));
  const motion::MotionSound sound =
      motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {});
  EXPECT_GT(peak(sound), 0);
  EXPECT_EQ(sound.impacts.calls, 1000u);
  // A thousand at once are one a thousand times as strong.
  Scrape one(sine_map(2e-3, 1e-6, 32, 4), 0.3, 5, 0.05);
  one.motion.contacts.clear();
  scene.motion.contacts.clear();
  one.motion.impacts = {strike(0.02, 1, 1e-4)};
  const motion::MotionSound many =
      motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {});
  const motion::MotionSound single =
      motion::motion_sound(one.motion, one.bodies, bodies, listeners, {});
  for (std::size_t n = 0; n < many.samples.size(); ++n) {
    ASSERT_NEAR(many.samples[n], single.samples[n], 1e-5 * peak(single));
  }
}

TEST(MovingSoundHard, StrikesAtBothEndsOfAnyDurationAndNone) {
  const Ball ball;
  Scrape scene(sine_map(2e-3, 0, 32, 4), 0, 5, 0.05);
  scene.motion.contacts.clear();
  scene.motion.impacts = {strike(0, 1e-3, 0), strike(0, 0, 1e-4), strike(0, 1e-3, 1),
                          strike(0.05, 1e-3, 1e-4), strike(0.0499999, 1e-3, 0)};
  const std::vector<motion::SoundingBody> bodies = {{}, ball.body()};
  EXPECT_GT(peak(motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {})), 0);
  motion::MotionSoundOptions longer;
  longer.seconds = 0.3;
  EXPECT_GT(peak(motion::motion_sound(scene.motion, scene.bodies, bodies, {}, longer)), 0);
}

TEST(MovingSoundHard, ABodyThatLeavesTheWorld) {
  const Ball ball;
  Scrape scene(sine_map(2e-3, 0, 32, 4), 0, 5, 0.3);
  scene.motion.contacts.clear();
  scene.motion.impacts = {strike(0.01, 1e-3, 1e-4)};
  for (std::size_t k = 0; k < scene.motion.states.size(); ++k) {
    // Faster than sound, away.
    scene.motion.states[k][1].pose.origin = {0, 0, -1000.0 * static_cast<double>(k) * 1e-3};
  }
  const std::vector<motion::SoundingBody> bodies = {{}, ball.body()};
  EXPECT_GT(peak(motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {})), 0);
  // Towards the listener it would be a shock wave: refused, with the time.
  for (std::size_t k = 0; k < scene.motion.states.size(); ++k) {
    scene.motion.states[k][1].pose.origin = {0, 0, -500 + 1000.0 * static_cast<double>(k) * 1e-3};
  }
  EXPECT_THROW(motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {}),
               core::InputError);
}

TEST(MovingSoundHard, HugeMassRatiosAndForces) {
  const Ball ball;
  for (const double mass : {1e-9, 1e9}) {
    for (const double force : {1e-12, 1e9}) {
      Scrape scene(sine_map(2e-3, 1e-4, 32, 4), 2, force, 0.05);
      scene.bodies[0].rigid.mass = mass;
      scene.bodies[0].youngs_modulus = scene.bodies[1].youngs_modulus = 2e11;
      scene.bodies[0].ball_radius = 0.01;
      scrape_over_the_top(scene);
      const std::vector<motion::SoundingBody> bodies = {{}, ball.body()};
      // The wave's own forces, were it not rounded off: F + m v^2 A k^2, along the face A k of it.
      const double wave = 2 * std::numbers::pi / 2e-3, steep = 1e-4 * wave;
      const double maximum = force + mass * 4 * steep * wave;
      motion::LastingForces forces(scene.motion, scene.bodies, {});
      const motion::LastingForce driving = forces.force(0);
      EXPECT_LT(driving.force.colwise().norm().maxCoeff(), 2 * (1 + steep) * maximum);
      EXPECT_GT(peak(motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {})), 0)
          << mass << " kg, " << force << " N";
    }
  }
}

TEST(MovingSoundHard, FasterThanTheTexelsCanBeSampled) {
  // 100 m/s over texels of 0.1 mm: 23 of them from sample to sample.
  const Ball ball;
  Scrape scene(sine_map(1e-3, 1e-5, 10, 10), 100, 5, 0.05);
  motion::LastingForceOptions options;
  options.roughness = 0;
  options.edge_radius = 0;
  motion::LastingForces forces(scene.motion, scene.bodies, options);
  const motion::LastingForce force = forces.force(0);
  // 100 kHz cannot be heard: m omega^2 h would be 4e5 N.
  EXPECT_LT(force.force.cwiseAbs().maxCoeff(), 5);
}

TEST(MovingSoundHard, NumbersThatAreNone) {
  const Ball ball;
  const std::vector<motion::SoundingBody> bodies = {{}, ball.body()};
  const auto refused = [&](const Scrape& scene) {
    EXPECT_THROW(motion::motion_sound(scene.motion, scene.bodies, bodies, listeners, {}),
                 core::InputError);
  };
  const Scrape fine(sine_map(2e-3, 1e-6, 32, 4), 0.3, 5, 0.05);
  Scrape scene = fine;
  scene.motion.contacts[0].steps[7].points[1].x() = NAN;
  refused(scene);
  scene = fine;
  scene.motion.contacts[0].steps[7].force.z() = NAN;
  refused(scene);
  scene = fine;
  scene.motion.impacts = {strike(0.01, NAN, 1e-4)};
  refused(scene);
  scene = fine;
  scene.motion.impacts = {strike(0.01, 1e-3, INFINITY)};
  refused(scene);
  scene = fine;
  scene.motion.states[9][1].pose.origin.x() = NAN;
  refused(scene);
}

}  // namespace
}  // namespace carillon::synth
