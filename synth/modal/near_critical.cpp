#include "synth/modal/near_critical.hpp"

#include <algorithm>

namespace carillon::synth::modal {

namespace {

/// Where a mode, which dies within a few periods, ends: relative to its own start.
constexpr double tail = 1e-17;

}  // namespace

void add_motion(const Resonances& resonances, const NearCriticalMotion& motion,
                std::vector<NearCritical>& modes) {
  const double lambda = resonances.eigenvalues[motion.index];
  const double d = resonances.decay_rates[motion.index];
  auto mode = std::find_if(modes.begin(), modes.end(),
                           [&](const NearCritical& other) { return other.index == motion.index; });
  if (mode == modes.end()) {
    const LinearForceStep step = linear_force_step(lambda, d, 1 / resonances.sample_rate);
    mode = modes.insert(mode, {motion.index, motion.gains, step, 0, 0, 0});
  }
  mode->displacement += motion.start.displacement;
  mode->velocity += motion.start.velocity;
  const ModalResponse decay(lambda, d, motion.start);
  mode->end = tail * decay.bound_after_contact(0, motion.gains);
}

void add_motions(const Resonances& resonances, const std::vector<NearCriticalMotion>& motions,
                 std::vector<NearCritical>& modes) {
  for (const NearCriticalMotion& motion : motions) add_motion(resonances, motion, modes);
}

void ring_on(const Resonances& resonances, std::span<NearCritical> modes,
             std::span<double> samples) {
  for (NearCritical& mode : modes) {
    const double lambda = resonances.eigenvalues[mode.index];
    const double d = resonances.decay_rates[mode.index];
    const LinearForceStep& step = mode.step;
    for (double& sample : samples) {
      const double q = mode.displacement;
      const double v = mode.velocity;
      sample += mode.gains.of({q, v, -2 * d * v - lambda * q});
      mode.displacement = step.qq * q + step.qv * v;
      mode.velocity = step.vq * q + step.vv * v;
    }
  }
}

void drop_gone(const Resonances& resonances, std::vector<NearCritical>& modes) {
  std::erase_if(modes, [&](const NearCritical& mode) {
    const ModalResponse decay(resonances.eigenvalues[mode.index],
                              resonances.decay_rates[mode.index],
                              ModalMotion{mode.displacement, mode.velocity, 0});
    return decay.bound_after_contact(0, mode.gains) <= mode.end;
  });
}

}  // namespace carillon::synth::modal
