#include "synth/motion/motion_sound.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "synth/motion/detail/body_sound.hpp"
#include "synth/motion/detail/check_motion.hpp"
#include "synth/motion/detail/flight_delay.hpp"

namespace carillon::synth::motion {

namespace {

/// A click is over so many times the sphere's radius over the speed of sound after the force.
constexpr double click_end = 30;

/// Clicks of both bodies of every impact, straight into the listeners' rows.
void add_clicks(const Motion& motion, std::span<const SoundingBody> bodies,
                std::span<const modal::Listener> listeners, const MotionSoundOptions& options,
                Eigen::MatrixXd& heard, MotionSound& report) {
  const Stopwatch watch(report.clicks);
  for (const Impact& impact : motion.impacts) {
    const modal::ContactForce force = pulse_of(impact, options);
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t body = impact.bodies[side];
      if (!bodies[body].click) continue;
      const contact::RigidSource& source = *bodies[body].click;
      const Pose pose = pose_at(motion, body, options.moving_radiation ? impact.time : 0);
      const Vec3 impulse = (side == 0 ? 1.0 : -1.0) * impact.impulse;
      const double first = std::floor(impact.time * options.sample_rate);
      for (std::size_t row = 0; row < listeners.size(); ++row) {
        const Vec3 place = pose.to_body(listeners[row].position);
        const double lasts = (place - source.centre).norm() / modal::speed_of_sound +
                             impact.duration +
                             click_end * source.radii.maxCoeff() / modal::speed_of_sound;
        const double end = std::min(static_cast<double>(heard.rows()),
                                    first + std::ceil(lasts * options.sample_rate) + 2);
        if (!(first < end)) continue;
        const std::vector<float> click =
            contact::acceleration_click(source, pose.turn.conjugate() * impulse, force, place,
                                        options.sample_rate, static_cast<std::size_t>(end - first),
                                        std::max(0.0, impact.time - first / options.sample_rate));
        for (std::size_t n = 0; n < click.size(); ++n) {
          heard(static_cast<Eigen::Index>(first) + static_cast<Eigen::Index>(n),
                static_cast<Eigen::Index>(row)) += static_cast<double>(click[n]);
        }
        ++report.clicks.calls;
      }
    }
  }
}

void check(const Motion& motion, std::span<const MovingBody> moving,
           std::span<const SoundingBody> bodies, const MotionSoundOptions& options) {
  if (motion.states.empty() || !(motion.step > 0)) {
    throw core::InputError("moving sound: a motion without states");
  }
  if (motion.states.front().size() != bodies.size() || moving.size() != bodies.size()) {
    throw core::InputError(fmt::format("moving sound: {} bodies sound where {} move", bodies.size(),
                                       motion.states.front().size()));
  }
  if (!(options.sample_rate > 0) || !std::isfinite(options.sample_rate) ||
      !(options.seconds >= 0) || !std::isfinite(options.seconds)) {
    throw core::InputError(
        fmt::format("moving sound: {} s at {} Hz", options.seconds, options.sample_rate));
  }
  check_finite(motion);
  const std::size_t tensions = motion.tensions.empty() ? 0 : motion.tensions.front().size();
  for (const SoundingBody& body : bodies) {
    for (const HoldingString& string : body.strings) {
      if (string.number < tensions) continue;
      throw core::InputError(
          fmt::format("moving sound: string {} of a motion of {}", string.number, tensions));
    }
  }
  if (!(options.turn > 0)) {
    throw core::InputError(
        fmt::format("moving sound: poses must be some angle apart, not {} rad", options.turn));
  }
}

}  // namespace

MotionSound motion_sound(const Motion& motion, std::span<const MovingBody> moving,
                         std::span<const SoundingBody> bodies,
                         std::span<const modal::Listener> listeners,
                         const MotionSoundOptions& options) {
  check(motion, moving, bodies, options);
  const double seconds = options.seconds > 0
                             ? options.seconds
                             : static_cast<double>(motion.states.size() - 1) * motion.step;
  const auto count = static_cast<Eigen::Index>(std::llround(seconds * options.sample_rate));
  MotionSound sound;
  sound.rows = std::max<std::size_t>(1, listeners.size());
  sound.unit = listeners.empty() ? "m/s" : "Pa";
  const auto rows = static_cast<Eigen::Index>(sound.rows);
  ContactForces forces(motion, moving, bodies, options);
  Eigen::MatrixXd heard = Eigen::MatrixXd::Zero(count, rows);
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    if (!sounds(bodies[body])) continue;
    BodySound own(motion, body, bodies[body], listeners, options, forces, sound);
    const Eigen::MatrixXd samples = own.emitted(count, rows);
    if (options.limit.passed()) options.limit.refuse();
    for (Eigen::Index row = 0; row < rows; ++row) {
      if (samples.col(row).isZero(0)) continue;
      const std::vector<double> flights = own.gains().flight_times(static_cast<std::size_t>(row));
      const Stopwatch watch(sound.moving_radiation);
      add_arriving(samples.col(row), {motion.step, flights}, options.sample_rate, heard.col(row));
    }
  }
  if (options.clicks && !listeners.empty()) {
    add_clicks(motion, bodies, listeners, options, heard, sound);
  }
  sound.samples.resize(static_cast<std::size_t>(heard.size()));
  for (std::size_t n = 0; n < sound.samples.size(); ++n) {
    sound.samples[n] = static_cast<float>(heard.data()[n]);
  }
  return sound;
}

}  // namespace carillon::synth::motion
