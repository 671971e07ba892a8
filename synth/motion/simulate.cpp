#include "synth/motion/simulate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "synth/motion/detail/bullet_world.hpp"
#include "synth/motion/detail/contact_tracker.hpp"

namespace carillon::synth::motion {

namespace {

bool finite(const BodyState& state) {
  return state.pose.origin.allFinite() && state.pose.turn.coeffs().allFinite() &&
         state.velocity.allFinite() && state.spin.allFinite();
}

void check(const MovingBody& body) {
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    throw core::InputError(fmt::format("{}: {}", body.name, what), hint);
  };
  if (!finite(body.start)) refuse("its start is not finite", "");
  if (!body.fixed && !(body.rigid.mass > 0 && (body.rigid.inertia.array() > 0).all())) {
    refuse(fmt::format("a body of {} kg cannot move", body.rigid.mass), "fix it, or give it mass");
  }
  if (!(body.release >= 0)) refuse("is let go before it begins", "");
  if (!(body.friction >= 0) || !(body.rolling_friction >= 0)) {
    refuse("friction must not be negative", "");
  }
  if (!(body.restitution >= 0 && body.restitution <= 1)) {
    refuse(fmt::format("restitution must lie between 0 and 1, not {}", body.restitution), "");
  }
  if (!(body.ball_radius > 0) && body.hulls.empty()) refuse("has no hull", "");
  if (body.texture && body.texture->map == nullptr) refuse("its texture has no map", "");
}

void check(std::span<const MotionString> strings, std::span<const MovingBody> bodies) {
  for (const MotionString& string : strings) {
    if (string.body >= bodies.size()) throw core::InputError("a string hangs on no body");
    if (!string.anchor.allFinite() || !string.at.allFinite() || !(string.length >= 0)) {
      throw core::InputError("a string's ends and length must be finite");
    }
    // What pulled a body up at once would be energy from nowhere.
    const MovingBody& body = bodies[string.body];
    const double distance = (body.start.pose.to_world(string.at) - string.anchor).norm();
    if (string.length > 0 && string.length < (1 - 1e-6) * distance) {
      throw core::InputError(
          fmt::format("{}: its string of {:.4g} m does not reach: its ends are {:.4g} m apart",
                      body.name, string.length, distance),
          "make it longer, or leave out its length: it is then taut at the start");
    }
  }
}

void check(const MotionOptions& options) {
  if (!(options.time_step > 0) || !(options.seconds > 0) || !std::isfinite(options.seconds)) {
    throw core::InputError(
        fmt::format("motion of {} s by steps of {} s", options.seconds, options.time_step),
        "both must be positive");
  }
  if (!options.gravity.allFinite()) throw core::InputError("gravity must be finite");
}

}  // namespace

double mechanical_energy(std::span<const MovingBody> bodies, std::span<const BodyState> states,
                         const Vec3& gravity) {
  double energy = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const MovingBody& body = bodies[b];
    if (body.fixed) continue;
    const BodyState& state = states[b];
    const Vec3 spin = body.rigid.axes.transpose() * (state.pose.turn.conjugate() * state.spin);
    energy += 0.5 * body.rigid.mass * state.velocity.squaredNorm() +
              0.5 * (body.rigid.inertia.array() * spin.array().square()).sum() -
              body.rigid.mass * gravity.dot(state.pose.to_world(body.rigid.centre));
  }
  return energy;
}

Motion simulate_motion(std::span<const MovingBody> bodies, std::span<const MotionString> strings,
                       const MotionOptions& options) {
  for (const MovingBody& body : bodies) check(body);
  check(strings, bodies);
  check(options);

  BulletWorld world(bodies, strings, options);
  ContactTracker tracker(bodies, options);
  Motion motion;
  motion.overlaps = world.overlaps(options.time_step);
  world.settle(options.time_step);
  motion.step = options.time_step;
  motion.left.assign(bodies.size(), std::numeric_limits<double>::infinity());
  const auto count =
      static_cast<std::size_t>(std::ceil(options.seconds / options.time_step - 1e-9));
  std::vector<BodyState> states;
  for (const MovingBody& body : bodies) {
    states.push_back(body.start);
    if (body.fixed || body.release > 0) states.back().velocity = states.back().spin = Vec3::Zero();
  }
  const auto record = [&] {
    motion.states.push_back(states);
    motion.energy.push_back(mechanical_energy(bodies, states, options.gravity));
  };
  record();
  for (std::size_t k = 0; k < count; ++k) {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (bodies[b].release > 0 &&
          bodies[b].release <= static_cast<double>(k) * options.time_step) {
        world.release(b);
      }
    }
    const int wanted = world.parts(options.time_step);
    const int parts = std::min(wanted, max_substep_count);
    if (wanted > max_substep_count && !motion.too_fast) {
      motion.too_fast = static_cast<double>(k) * options.time_step;
    }
    motion.max_substeps = std::max(motion.max_substeps, parts);
    const double part = options.time_step / parts;
    std::vector<double> tensions(strings.size(), 0);
    for (int p = 0; p < parts; ++p) {
      world.step(part);
      for (std::size_t b = 0; b < bodies.size(); ++b) {
        if (bodies[b].fixed || std::isfinite(motion.left[b])) continue;
        states[b] = world.state(b);
        if (!finite(states[b])) {
          throw core::Error(fmt::format("{}: its motion is not finite at {:.4f} s", bodies[b].name,
                                        static_cast<double>(k) * options.time_step),
                            "a shorter motion.time_step may help");
        }
      }
      tracker.add(world.contacts(), static_cast<double>(k) * options.time_step + p * part, part,
                  states);
      const std::vector<double> pulls = world.tensions();
      for (std::size_t s = 0; s < pulls.size(); ++s) tensions[s] += pulls[s] / parts;
    }
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (bodies[b].fixed || std::isfinite(motion.left[b])) continue;
      if (states[b].pose.origin.norm() <= options.world_radius) continue;
      world.take_out(b);
      motion.left[b] = (static_cast<double>(k) + 1) * options.time_step;
      states[b].velocity = states[b].spin = Vec3::Zero();
    }
    tracker.end_step(k);
    motion.tensions.push_back(std::move(tensions));
    record();
    if (options.limit.passed()) options.limit.refuse();
  }
  tracker.finish(motion);
  return motion;
}

}  // namespace carillon::synth::motion
