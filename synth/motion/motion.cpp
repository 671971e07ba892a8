#include "synth/motion/motion.hpp"

#include <algorithm>

namespace carillon::synth::motion {

Pose pose_at(const Motion& motion, std::size_t body, double time) {
  const double place = std::max(0.0, time / motion.step);
  const std::size_t last = motion.states.size() - 1;
  const auto step = std::min(static_cast<std::size_t>(place), last);
  const Pose& from = motion.states[step][body].pose;
  if (step == last) return from;
  const Pose& to = motion.states[step + 1][body].pose;
  const double fraction = place - static_cast<double>(step);
  return {from.turn.slerp(fraction, to.turn), from.origin + fraction * (to.origin - from.origin)};
}

}  // namespace carillon::synth::motion
