#include "synth/motion/motion_sound.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "synth/contact/hertz_pulse.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/motion/detail/contact_places.hpp"
#include "synth/motion/detail/moving_gains.hpp"
#include "tests/synth/scraped_face.hpp"
#include "tests/synth/sounding_ball.hpp"

namespace carillon::synth {
namespace {

double difference(const std::vector<float>& a, const std::vector<float>& b) {
  double peak = 0, worst = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    peak = std::max(peak, std::abs(double(b[n])));
    worst = std::max(worst, std::abs(double(a[n]) - double(b[n])));
  }
  return worst / peak;
}

/// What synthesize() makes of a strike on a ball.
std::vector<float> struck(const Ball& ball, const motion::Impact& impact,
                          const modal::ContactForce& force, modal::Readout readout,
                          std::size_t count) {
  const modal::SurfaceSampler sampler(ball.modes.surface);
  const modal::Strike strike = {sampler.nearest(impact.points[0]), impact.impulse.normalized(),
                                impact.impulse.norm(), force};
  for (double& delay : readout.delays) delay += impact.time;
  return modal::synthesize(modal::ring_down(ball.modes, ball.body.decay_rates, strike, readout),
                           force, audio_rate, count);
}

TEST(MotionSound, AStrikeOnABodyAtRestIsThatOfSynthesize) {
  const Ball ball(2, {900, 2500, 7000}, 30);
  motion::Motion motion =
      hand_made_motion(0.2, 1e-3, 2, [](std::size_t, double) { return at(Vec3::Zero()); });
  motion.impacts = {strike(0.0123, {0, 0, fixed_radius}, {0, 0.1, -0.3}, 3e-4)};
  const std::vector<motion::SoundingBody> bodies = {ball.body, {}};
  motion::MotionSoundOptions options;
  const auto count = static_cast<std::size_t>(0.2 * audio_rate);
  for (const bool hertz : {false, true}) {
    options.hertz_pulses = hertz;
    const modal::ContactForce force =
        hertz ? contact::hertz_pulse(3e-4) : modal::ContactForce{3e-4};
    const motion::MotionSound dry = motion::motion_sound(motion, at_rest, bodies, {}, options);
    EXPECT_EQ(dry.unit, "m/s");
    EXPECT_LT(difference(dry.samples, struck(ball, motion.impacts[0], force,
                                             motion::mean_square_velocity(ball.modes), count)),
              1e-6);
    const std::vector<modal::Listener> listeners = {{{0.4, 0.1, 0.5}}, {{-0.2, 0, 2}}};
    const motion::MotionSound wet =
        motion::motion_sound(motion, at_rest, bodies, listeners, options);
    EXPECT_EQ(wet.unit, "Pa");
    EXPECT_EQ(wet.rows, 2u);
    const modal::Readout readout = radiation::pressure_readout(ball.field.pressure_at(listeners),
                                                               ball.modes, ball.body.decay_rates);
    // The force's corners have no band limit, which interpolation between samples shows.
    std::vector<float> expected = struck(ball, motion.impacts[0], force, readout, count);
    std::vector<float> found = wet.samples;
    EXPECT_LT(difference(found, expected), 4e-3);
    for (std::size_t row = 0; row < 2; ++row) {
      const double arrival = motion.impacts[0].time + readout.delays[row];
      const auto corner = static_cast<std::size_t>(arrival * audio_rate);
      for (std::size_t n = corner - 40; n < corner + 60; ++n) {
        found[row * count + n] = expected[row * count + n] = 0;
      }
    }
    EXPECT_LT(difference(found, expected), 5e-5);
    EXPECT_EQ(wet.impacts.calls, 1u);
    EXPECT_EQ(wet.moving_radiation.calls, 1u);
    EXPECT_EQ(wet.contact_damping.calls, 0u);
    EXPECT_EQ(wet.clicks.calls, 0u);
  }
}

// Equal bodies at one place, struck against each other: opposite forces, so that nothing remains.
TEST(MotionSound, ImpactsStrikeBothBodiesOppositely) {
  const Ball ball(1, {900, 2500}, 30);
  motion::Motion motion = hand_made_motion(0.1, 1e-3, 2, [](std::size_t, double) {
    return at({0.1, 0, 0});
  });
  motion.impacts = {strike(0.01, {0, 0, fixed_radius}, {0, 0.1, -0.3}, 3e-4)};
  const std::vector<modal::Listener> listeners = {{{0.4, 0.1, 0.5}}};
  const std::vector<motion::SoundingBody> one = {ball.body, {}}, both = {ball.body, ball.body};
  const motion::MotionSound alone = motion::motion_sound(motion, at_rest, one, listeners, {});
  const motion::MotionSound together = motion::motion_sound(motion, at_rest, both, listeners, {});
  EXPECT_EQ(together.impacts.calls, 2u);
  double peak = 0, left = 0;
  for (std::size_t n = 0; n < alone.samples.size(); ++n) {
    peak = std::max(peak, std::abs(double(alone.samples[n])));
    left = std::max(left, std::abs(double(together.samples[n])));
  }
  EXPECT_GT(peak, 1e-3);
  EXPECT_LT(left, 1e-9 * peak);
}

motion::LastingContact resting(const Vec3& point, const Vec3& normal, double force,
                               std::size_t first, std::size_t steps) {
  motion::LastingContact contact;
  contact.bodies = {0, 1};
  contact.first_step = first;
  for (std::size_t k = 0; k < steps; ++k) {
    motion::ContactStep step;
    step.points = {point, point};
    step.normal = normal;
    step.sweep = {Vec3::Zero(), Vec3::Zero()};
    // A solver's chatter about the mean.
    step.force = (k % 2 == 0 ? 1.8 : 0.2) * force * normal;
    contact.steps.push_back(step);
  }
  return contact;
}

/// Decay rate between two times [1/s].
double decay(const motion::MotionSound& sound, double from, double to) {
  const auto level = [&](double time) {
    const auto begin = static_cast<std::size_t>(time * audio_rate);
    double sum = 0;
    for (std::size_t n = begin; n < begin + 882; ++n) sum += std::pow(sound.samples[n], 2);
    return std::log(sum) / 2;
  };
  return (level(from) - level(to)) / (to - from);
}

/// A mode that decays at 2 1/s does so faster by `added` [1/s] from step 200 to 400.
void expect_damped_from_200_to_400(const motion::Motion& motion,
                                   const std::vector<motion::SoundingBody>& bodies, double added) {
  const motion::MotionSound sound = motion::motion_sound(motion, at_rest, bodies, {}, {});
  EXPECT_EQ(sound.contact_damping.calls, 200u);
  EXPECT_GT(added, 0.5);
  EXPECT_NEAR(decay(sound, 0.05, 0.15), 2, 0.01);
  EXPECT_NEAR(decay(sound, 0.25, 0.35), 2 + added, 0.02 * added);
  EXPECT_NEAR(decay(sound, 0.45, 0.55), 2, 0.01);
  motion::MotionSoundOptions off;
  off.contact_damping = false;
  EXPECT_EQ(motion::motion_sound(motion, at_rest, bodies, {}, off).contact_damping.calls, 0u);
}

TEST(MotionSound, ContactsDampWhileTheyLast) {
  Ball ball(1, {1500}, 2);
  ball.body.rests = {"felt", 0.5, 0.3, ""};
  motion::Motion motion =
      hand_made_motion(0.6, 1e-3, 2, [](std::size_t, double) { return at(Vec3::Zero()); });
  motion.impacts = {strike(0.001, {0, 0, fixed_radius}, {0, 0, -0.3}, 3e-4)};
  const Vec3 normal = Vec3(0.6, 0, 0.8);
  motion.contacts = {resting({0, 0, -fixed_radius}, normal, 10, 200, 200)};
  const std::vector<motion::SoundingBody> bodies = {ball.body, {}};
  const modal::SurfaceSampler sampler(ball.modes.surface);
  const modal::SurfacePoint point = sampler.nearest({0, 0, -fixed_radius});
  const std::vector<support::Contact> contact = {{point, normal}};
  const double unit = support::contact_factor(ball.modes, contact, 0.3).row(0).squaredNorm();
  EXPECT_NEAR(motion::unit_damping(modal::shapes_at(ball.modes, point), normal, 0.3)[0], unit,
              1e-6 * unit);
  expect_damped_from_200_to_400(motion, bodies, 0.5 * 10 * unit / 2);
}

// A string takes from a mode what a contact would that is pressed as hard as it pulls.
TEST(MotionSound, StringsDampByTheirTension) {
  Ball ball(1, {1500}, 2);
  const Vec3 anchor(0.3, 0, 0.4), point(0, 0, fixed_radius);
  ball.body.strings = {{1, point, anchor, {"felt", 0.5, 0.3, ""}}};
  motion::Motion motion =
      hand_made_motion(0.6, 1e-3, 2, [](std::size_t, double) { return at(Vec3::Zero()); });
  motion.impacts = {strike(0.001, point, {0, 0, -0.3}, 3e-4)};
  for (std::size_t k = 0; k < 600; ++k) {
    motion.tensions.push_back({7, k >= 200 && k < 400 ? 10.0 : 0.0});
  }
  const std::vector<motion::SoundingBody> bodies = {ball.body, {}};
  const modal::SurfaceSampler sampler(ball.modes.surface);
  const Vec3 along = (anchor - point).normalized();
  const std::vector<support::Contact> contact = {{sampler.nearest(point), along}};
  const double unit = support::contact_factor(ball.modes, contact, 0.3).row(0).squaredNorm();
  expect_damped_from_200_to_400(motion, bodies, 0.5 * 10 * unit / 2);
  motion.tensions.clear();
  EXPECT_THROW(motion::motion_sound(motion, at_rest, bodies, {}, {}), core::InputError);
}

TEST(MotionSound, PartsAreSwitchedOffAndSaySo) {
  Ball ball(1, {1500}, 2);
  ball.body.click = contact::rigid_source(ball.modes.surface, 0.3);
  motion::Motion motion = hand_made_motion(0.1, 1e-3, 2, [](std::size_t body, double) {
    return at({0, 0, body == 0 ? 0.0 : 2 * fixed_radius});
  });
  motion.impacts = {strike(0.01, {0, 0, fixed_radius}, {0, 0, -0.3}, 1e-4)};
  const std::vector<motion::SoundingBody> bodies = {ball.body, {}};
  const std::vector<modal::Listener> listeners = {{{0.3, 0.1, 0.5}}};
  motion::MotionSoundOptions clicks_alone;
  clicks_alone.impacts = false;
  const motion::MotionSound click =
      motion::motion_sound(motion, at_rest, bodies, listeners, clicks_alone);
  EXPECT_EQ(click.clicks.calls, 1u);
  EXPECT_EQ(click.impacts.calls, 0u);
  EXPECT_EQ(click.mode_samples, 0u);
  const auto expected =
      contact::acceleration_click(*ball.body.click, {0, 0, -0.3}, {1e-4}, listeners[0].position,
                                  audio_rate, click.samples.size(), 0.01);
  EXPECT_LT(difference(click.samples, expected), 1e-5);
  motion::MotionSoundOptions none = clicks_alone;
  none.clicks = false;
  for (const float sample :
       motion::motion_sound(motion, at_rest, bodies, listeners, none).samples) {
    EXPECT_EQ(sample, 0.0F);
  }
  const motion::MotionSound once = motion::motion_sound(motion, at_rest, bodies, listeners, {});
  EXPECT_EQ(once.samples, motion::motion_sound(motion, at_rest, bodies, listeners, {}).samples);
  EXPECT_GT(once.mode_samples, 0u);
}

// A sine of 2 mm under a tip at 0.5 m/s: 250 Hz, and modes at 900 and 2500 Hz.
TEST(MotionSound, AScrapedFaceSoundsAtSpeedOverWavelength) {
  const Ball ball(1, {900, 2500}, 20);
  Scrape scrape(sine_map(2e-3, 1e-6, 32, 16), 0.5, 5, 0.5);
  // The face hangs off the ball that stands for its body: contacts are at the nearest point.
  scrape.bodies[1].texture->origin.z() = 3;
  for (motion::ContactStep& step : scrape.motion.contacts[0].steps) step.points[1].z() = 3;
  const std::vector<motion::SoundingBody> bodies = {{}, ball.body};
  motion::MotionSoundOptions options;
  options.contacts.edge_radius = 0;
  options.contacts.roughness = 0;
  const motion::MotionSound sound =
      motion::motion_sound(scrape.motion, scrape.bodies, bodies, {}, options);
  EXPECT_EQ(sound.lasting_contacts.calls, 500u);
  const auto level = [&](double frequency) {
    std::complex<double> sum;
    for (std::size_t n = 8000; n < 20000; ++n) {
      const double window = 1 - std::cos(2 * pi * (double(n - 8000) + 0.5) / 12000);
      sum += window * double(sound.samples[n]) *
             std::polar(1.0, -2 * pi * frequency * double(n) / audio_rate);
    }
    return std::abs(sum);
  };
  EXPECT_GT(level(250), 100 * level(230));
  EXPECT_GT(level(250), 100 * level(270));
  EXPECT_GT(level(250), 30 * level(900));
  EXPECT_EQ(sound.samples,
            motion::motion_sound(scrape.motion, scrape.bodies, bodies, {}, options).samples);
  // Without the map and without roughness: silence, at no cost.
  options.contacts.map = false;
  const motion::MotionSound flat =
      motion::motion_sound(scrape.motion, scrape.bodies, bodies, {}, options);
  EXPECT_EQ(flat.lasting_contacts.calls, 0u);
  EXPECT_EQ(flat.mode_samples, 0u);
  for (const float sample : flat.samples) ASSERT_EQ(sample, 0.0F);
  options.contacts.map = true;
  options.lasting_contacts = false;
  const motion::MotionSound off =
      motion::motion_sound(scrape.motion, scrape.bodies, bodies, {}, options);
  EXPECT_EQ(off.lasting_contacts.calls, 0u);
  for (const float sample : off.samples) ASSERT_EQ(sample, 0.0F);
}

// Both bodies feel the contact, oppositely: equal ones at one place cancel.
TEST(MotionSound, LastingContactsDriveBothBodies) {
  const Ball ball(1, {900, 2500}, 20);
  Scrape scrape(sine_map(2e-3, 1e-6, 32, 16), 0, 5, 0.3);
  scrape.bodies[1].texture.reset();
  for (std::size_t k = 0; k < scrape.motion.contacts[0].steps.size(); ++k) {
    // Both surfaces' places move, as in rolling.
    const double way = 0.0002 * static_cast<double>(k);
    scrape.motion.contacts[0].steps[k].points = {Vec3(way, 0.03, 0.05), Vec3(way, 0.03, 0.05)};
    scrape.motion.contacts[0].steps[k].slip = Vec3(0.2, 0, 0);
  }
  for (auto& states : scrape.motion.states) states[0] = states[1];
  const std::vector<modal::Listener> listeners = {{{0.4, 0.1, 0.5}}};
  const auto peak = [](const motion::MotionSound& sound) {
    double largest = 0;
    for (const float sample : sound.samples) largest = std::max(largest, std::abs(double(sample)));
    return largest;
  };
  const std::vector<motion::SoundingBody> one = {ball.body, {}}, both = {ball.body, ball.body};
  const motion::MotionSound alone =
      motion::motion_sound(scrape.motion, scrape.bodies, one, listeners, {});
  const motion::MotionSound together =
      motion::motion_sound(scrape.motion, scrape.bodies, both, listeners, {});
  EXPECT_EQ(together.lasting_contacts.calls, 2 * alone.lasting_contacts.calls);
  EXPECT_GT(peak(alone), 0);
  EXPECT_LT(peak(together), 1e-9 * peak(alone));
}

TEST(MotionSound, RefusesWhatCannotBe) {
  const Ball ball(1, {1500}, 2);
  motion::Motion motion = hand_made_motion(0.1, 1e-3, 2, [](std::size_t, double time) {
    return at({0, 0, 5 * time});
  });
  motion.impacts = {strike(0.001, {0, 0, fixed_radius}, {0, 0, -0.3}, 1e-4)};
  const std::vector<motion::SoundingBody> bodies = {ball.body, {}};
  EXPECT_THROW(motion::motion_sound(motion, at_rest, std::span(bodies).first(1), {}, {}),
               core::InputError);
  EXPECT_THROW(motion::motion_sound({}, at_rest, bodies, {}, {}), core::InputError);
  motion::MotionSoundOptions endless;
  endless.seconds = INFINITY;
  EXPECT_THROW(motion::motion_sound(motion, at_rest, bodies, {}, endless), core::InputError);
  motion::SoundingBody deaf = ball.body;
  deaf.field = nullptr;
  const std::vector<modal::Listener> listeners = {{{0, 0, 0.3}}};
  EXPECT_THROW(motion::motion_sound(motion, at_rest, std::vector<motion::SoundingBody>{deaf, {}},
                                    listeners, {}),
               core::InputError);
  // The ball flies through the listener.
  try {
    motion::motion_sound(motion, at_rest, bodies, listeners, {});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("body 0 at 0.0"), std::string::npos) << error.message();
  }
}

}  // namespace
}  // namespace carillon::synth
