#include "synth/modal/row_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

namespace carillon::synth::modal {

namespace {

using Pole = std::complex<double>;

/// The coordinate's own part of a voice: its value over the weights at its pole.
Pole coordinate(const Voice& voice, const Weights& weights, const Pole& s) {
  const Pole weight = weights.displacement + s * (weights.velocity + s * weights.acceleration);
  return weight == 0.0 ? 0.0 : voice.value / weight;
}

bool is_finite(const ModalMotion& motion) {
  return std::isfinite(motion.displacement) && std::isfinite(motion.velocity);
}

}  // namespace

void find_motions(const Resonances& resonances, const Readout& readout, Eigen::Index row,
                  std::span<const Voice> voices, std::span<const NearCritical> near_critical,
                  double before, std::span<ModalMotion> motions) {
  std::fill(motions.begin(), motions.end(), ModalMotion{});
  auto voice = voices.begin();
  for (const Resonances::Mode& mode : resonances.modes) {
    const double lambda = resonances.eigenvalues[mode.index];
    const double d = resonances.decay_rates[mode.index];
    ModalMotion& motion = motions[mode.index];
    if (mode.rotations == 0) {
      const auto found = std::find_if(near_critical.begin(), near_critical.end(),
                                      [&](const auto& n) { return n.index == mode.index; });
      if (found == near_critical.end()) continue;
      motion = {found->displacement, found->velocity};
    }
    const Weights weights = weights_of(readout, row, static_cast<Eigen::Index>(mode.index), 1);
    const std::array<Partial, 2> poles = ModalResponse(lambda, d, 0).poles();
    for (std::size_t k = 0; k < mode.rotations; ++k) {
      const Rotation* rotation = &resonances.rotations[mode.rotation + k];
      if (voice == voices.end() || voice->rotation != rotation) continue;
      const Pole s(-poles[k].decay_rate, static_cast<double>(poles[k].angular_frequency));
      const Pole c = coordinate(*voice++, weights, s);
      motion.displacement += c.real();
      motion.velocity += (s * c).real();
    }
    if (motion.displacement == 0 && motion.velocity == 0) continue;
    motion = ModalResponse(lambda, d, motion).after_contact(-before);
    // A mode that dies within a sample has nothing left to go back from.
    if (!is_finite(motion)) motion = {};
  }
}

void add_contact_motions(const Resonances& resonances, const Eigen::VectorXd& excitation,
                         const ContactForce& force, double t, double factor,
                         std::span<ModalMotion> motions) {
  const double turn = 2 * std::numbers::pi * (t / force.duration);
  const std::complex<double> up(std::cos(turn), std::sin(turn));
  for (const Resonances::Mode& mode : resonances.modes) {
    const double share = factor * excitation[static_cast<Eigen::Index>(mode.index)];
    if (share == 0) continue;
    const double lambda = resonances.eigenvalues[mode.index];
    const double d = resonances.decay_rates[mode.index];
    ModalMotion& motion = motions[mode.index];
    if (!force.samples.empty()) {
      const ModalMotion forced = SampledResponse(lambda, d, force).at(t);
      motion.displacement += share * forced.displacement;
      motion.velocity += share * forced.velocity;
      continue;
    }
    const ModalResponse response(lambda, d, force.duration);
    if (!response.contact_splits()) {
      const ModalMotion forced = response.during_contact(t);
      motion.displacement += share * forced.displacement;
      motion.velocity += share * forced.velocity;
      continue;
    }
    const auto forced = [&](const Weights& weights) {
      const ForcedMotion part = response.forced_motion(weights);
      return part.constant + (part.turning * up).real();
    };
    motion.displacement += share * forced({.displacement = 1});
    motion.velocity += share * forced({.velocity = 1});
  }
}

void ring_from(const Resonances& resonances, const Readout& readout, Eigen::Index row,
               std::span<const ModalMotion> motions, double before, std::vector<Voice>& voices,
               std::vector<NearCritical>& near_critical) {
  voices.clear();
  near_critical.clear();
  for (const Resonances::Mode& mode : resonances.modes) {
    const ModalMotion& begin = motions[mode.index];
    if (begin.displacement == 0 && begin.velocity == 0) continue;
    const Weights weights = weights_of(readout, row, static_cast<Eigen::Index>(mode.index), 1);
    if (!weights.any()) continue;
    const double lambda = resonances.eigenvalues[mode.index];
    const double d = resonances.decay_rates[mode.index];
    const ModalMotion now = ModalResponse(lambda, d, begin).after_contact(before);
    const ModalResponse decay(lambda, d, now);
    if (mode.rotations == 0) {
      add_motion(resonances, {mode.index, weights, now}, near_critical);
      continue;
    }
    const std::array<Partial, 2> partials = decay.partials(weights);
    for (std::size_t k = 0; k < mode.rotations; ++k) {
      if (partials[k].amplitude == 0.0) continue;
      voices.push_back({&resonances.rotations[mode.rotation + k], partials[k].amplitude});
    }
  }
}

}  // namespace carillon::synth::modal
