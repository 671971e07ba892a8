#pragma once

#include <cmath>
#include <functional>

#include "synth/motion/motion.hpp"

namespace carillon::synth {

/// A motion in which each body has a given pose at each time.
inline motion::Motion hand_made_motion(
    double seconds, double step, std::size_t bodies,
    const std::function<motion::Pose(std::size_t body, double time)>& pose) {
  motion::Motion motion;
  motion.step = step;
  const auto steps = static_cast<std::size_t>(std::lround(seconds / step));
  for (std::size_t k = 0; k <= steps; ++k) {
    std::vector<motion::BodyState> states(bodies);
    for (std::size_t body = 0; body < bodies; ++body) {
      states[body].pose = pose(body, static_cast<double>(k) * step);
    }
    motion.states.push_back(std::move(states));
  }
  motion.left.assign(bodies, std::numeric_limits<double>::infinity());
  return motion;
}

}  // namespace carillon::synth
