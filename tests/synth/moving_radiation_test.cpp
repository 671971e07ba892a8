// How moving bodies are heard: flight times, Doppler shifts, gains that follow their poses.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "core/error.hpp"
#include "synth/motion/detail/flight_delay.hpp"
#include "synth/motion/detail/moving_gains.hpp"
#include "tests/synth/sounding_ball.hpp"

namespace carillon::synth {
namespace {

TEST(FlightDelay, IsExactTo96DecibelsInTheBand) {
  constexpr Eigen::Index sample_count = 3000;
  for (const double frequency : {100.0, 5000.0, 18000.0}) {
    for (const double flight : {0.0, 0.01, 0.012345678}) {
      Eigen::VectorXd emitted(sample_count), heard = Eigen::VectorXd::Zero(sample_count);
      for (Eigen::Index n = 0; n < sample_count; ++n) {
        emitted[n] = std::sin(2 * pi * frequency * double(n) / audio_rate);
      }
      const std::vector<double> flights = {flight};
      motion::add_arriving(emitted, {1e-3, flights}, audio_rate, heard);
      for (Eigen::Index n = 600; n < sample_count - 40; ++n) {
        EXPECT_NEAR(heard[n], std::sin(2 * pi * frequency * (double(n) / audio_rate - flight)),
                    1.6e-5);
      }
      if (flight > 0) {
        EXPECT_TRUE(heard.head(100).isZero(0));
      }
    }
  }
}

TEST(FlightDelay, RefusesWhatIsFasterThanSound) {
  const Eigen::VectorXd emitted = Eigen::VectorXd::Ones(10);
  Eigen::VectorXd heard = emitted;
  const std::vector<double> fast = {0.01, 0.008}, negative = {-1.0}, none;
  EXPECT_THROW(motion::add_arriving(emitted, {1e-3, fast}, audio_rate, heard), core::InputError);
  EXPECT_THROW(motion::add_arriving(emitted, {1e-3, negative}, audio_rate, heard),
               core::InputError);
  EXPECT_THROW(motion::add_arriving(emitted, {1e-3, none}, audio_rate, heard), core::InputError);
}

/// Frequency of a sinusoid from the phase it gains over a stretch, by its product with another.
double pitch(const float* samples, std::size_t count, double near) {
  const auto phase = [&](std::size_t from) {
    std::complex<double> sum;
    for (std::size_t n = from; n < from + 4000; ++n) {
      const double window = 1 - std::cos(2 * pi * (double(n - from) + 0.5) / 4000);
      sum += window * double(samples[n]) * std::polar(1.0, -2 * pi * near * double(n) / audio_rate);
    }
    return std::arg(sum);
  };
  const std::size_t far = count - 4000;
  return near + (phase(far) - phase(0)) / (2 * pi * double(far) / audio_rate);
}

TEST(MotionSound, PitchIsThatOfASourceThatMoves) {
  const double frequency = 1500;
  const Ball ball(0, {frequency}, 0.5);
  const std::vector<modal::Listener> listeners = {{{0, 0, 30}}};
  const std::vector<motion::SoundingBody> bodies = {ball.body, {}};
  for (const double speed : {-25.0, 12.0}) {
    motion::Motion motion = hand_made_motion(0.5, 1e-3, 2, [&](std::size_t, double time) {
      return at({0, 0, speed * time});
    });
    motion.impacts = {strike(0.001, {0, 0, fixed_radius}, {0, 0, -0.3}, 3e-4)};
    const motion::MotionSound sound = motion::motion_sound(motion, at_rest, bodies, listeners, {});
    const double heard = frequency / (1 - speed / modal::speed_of_sound);
    EXPECT_NEAR(pitch(sound.samples.data() + 6000, 12000, heard), heard, 0.02);
    EXPECT_GT(sound.moving_radiation.calls, 3u);
    // Nearer is louder: 1 / r of when it left.
    const auto level = [&](std::size_t from) {
      double sum = 0;
      for (std::size_t n = from; n < from + 2000; ++n) sum += std::pow(sound.samples[n], 2);
      return std::sqrt(sum);
    };
    const auto distance = [&](double t) {
      return (30 - speed * t) / (1 - speed / modal::speed_of_sound);
    };
    const double t0 = 7000 / audio_rate, t1 = 19000 / audio_rate;
    EXPECT_NEAR(level(18000) / level(6000),
                distance(t0) / distance(t1) * std::exp(-0.5 * (t1 - t0)), 0.01);
    motion::MotionSoundOptions still;
    still.moving_radiation = false;
    const motion::MotionSound unmoved =
        motion::motion_sound(motion, at_rest, bodies, listeners, still);
    EXPECT_NEAR(pitch(unmoved.samples.data() + 6000, 12000, frequency), frequency, 0.02);
    EXPECT_EQ(unmoved.moving_radiation.calls, 1u);
  }
}

// A dipole that turns is heard by the cosine of its angle.
TEST(MotionSound, GainsFollowABodyThatTurns) {
  const Ball ball(1, {1500}, 0.2);
  const double spin = 2 * pi * 3;
  motion::Motion motion = hand_made_motion(0.5, 1e-3, 2, [&](std::size_t, double time) {
    return motion::Pose{Eigen::Quaterniond(Eigen::AngleAxisd(spin * time, Vec3::UnitX())),
                        Vec3::Zero()};
  });
  motion.impacts = {strike(0.001, {0, 0, fixed_radius}, {0, 0, -0.3}, 3e-4)};
  const std::vector<modal::Listener> listeners = {{{0, 0, 1}}};
  const std::vector<motion::SoundingBody> bodies = {ball.body, {}};
  const motion::MotionSound sound = motion::motion_sound(motion, at_rest, bodies, listeners, {});
  const auto envelope = [&](double time) {
    const auto from = static_cast<std::size_t>(time * audio_rate) - 147;
    std::complex<double> sum;
    for (std::size_t n = from; n < from + 294; ++n) {  // ten periods
      sum += double(sound.samples[n]) * std::polar(1.0, -2 * pi * 1500 * double(n) / audio_rate);
    }
    return std::abs(sum);
  };
  const auto left = [&](double time) { return time - 1 / modal::speed_of_sound; };
  // Where it points at the listener, after a whole turn.
  const double ahead = 1 / 3.0 + 1 / modal::speed_of_sound;
  const double loud = envelope(ahead);
  for (double time = 0.1; time < 0.45; time += 0.013) {
    const double expected = std::abs(std::cos(spin * left(time))) * std::exp(-0.2 * (time - ahead));
    EXPECT_NEAR(envelope(time) / loud, expected, 0.02) << time;
  }
}

TEST(MovingGains, LieBetweenThoseOfTheKeys) {
  const Ball ball(1, {1500, 4000}, 0.2);
  const motion::Motion motion = hand_made_motion(0.1, 1e-3, 1, [&](std::size_t, double time) {
    return motion::Pose{Eigen::Quaterniond(Eigen::AngleAxisd(9 * time, Vec3::UnitX())),
                        Vec3(0, 0.3 * time, time)};
  });
  const std::vector<modal::Listener> listeners = {{{0.2, 0.5, 1}}};
  motion::MovingGains gains(motion, 0, ball.body, listeners, 0.05, true);
  for (std::size_t step = 0; step < 100; ++step) {
    const motion::DrivenGains over = gains.over(step);
    for (const std::size_t end : {0U, 1U}) {
      const std::vector<modal::Listener> place = {
          {motion.states[step + end][0].pose.to_body(listeners[0].position)}};
      const modal::Readout exact = radiation::pressure_readout(ball.field.pressure_at(place),
                                                               ball.modes, ball.body.decay_rates);
      const double fraction = end == 0 ? over.begin : over.end;
      const Eigen::MatrixXd between =
          (1 - fraction) * over.before->acceleration + fraction * over.after->acceleration;
      EXPECT_LT((between - exact.acceleration).norm(), 1e-3 * exact.acceleration.norm())
          << step << ' ' << end;
    }
  }
  EXPECT_GT(gains.poses(), 10u);
  EXPECT_LT(gains.poses(), 40u);
}

}  // namespace
}  // namespace carillon::synth
