#include "synth/motion/detail/check_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::synth::motion {

void check_finite(const Motion& motion) {
  const std::size_t bodies = motion.states.empty() ? 0 : motion.states.front().size();
  for (std::size_t k = 0; k < motion.states.size(); ++k) {
    for (std::size_t body = 0; body < motion.states[k].size(); ++body) {
      const Pose& pose = motion.states[k][body].pose;
      if (pose.origin.allFinite() && pose.turn.coeffs().allFinite()) continue;
      throw core::InputError(fmt::format("moving sound: body {} is nowhere at {:.4g} s", body,
                                         static_cast<double>(k) * motion.step));
    }
  }
  for (const Impact& impact : motion.impacts) {
    const bool fine = impact.impulse.allFinite() && impact.time >= 0 &&
                      std::isfinite(impact.time) && std::isfinite(impact.duration) &&
                      impact.points[0].allFinite() && impact.points[1].allFinite();
    if (!fine || std::max(impact.bodies[0], impact.bodies[1]) >= bodies) {
      throw core::InputError(fmt::format("moving sound: an impact at {} s of {} N s is none",
                                         impact.time, impact.impulse.norm()));
    }
  }
  for (const LastingContact& contact : motion.contacts) {
    for (std::size_t k = 0; k < contact.steps.size(); ++k) {
      const ContactStep& step = contact.steps[k];
      if (step.force.allFinite() && step.normal.allFinite() && step.slip.allFinite() &&
          step.points[0].allFinite() && step.points[1].allFinite() &&
          std::max(contact.bodies[0], contact.bodies[1]) < bodies) {
        continue;
      }
      throw core::InputError(
          fmt::format("moving sound: a contact of bodies {} and {} is not finite at {:.4g} s",
                      contact.bodies[0], contact.bodies[1],
                      static_cast<double>(contact.first_step + k) * motion.step));
    }
  }
}

}  // namespace carillon::synth::motion
