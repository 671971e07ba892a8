#pragma once

#include <numbers>
#include <vector>

#include "synth/motion/motion_sound.hpp"
#include "tests/synth/hand_made_motion.hpp"
#include "tests/synth/radiators.hpp"

namespace carillon::synth {

inline const std::vector<motion::MovingBody> at_rest(2);
inline constexpr double audio_rate = 44100, fixed_radius = 0.05, pi = std::numbers::pi;

/// A ball whose surface moves as Legendre's polynomial of an order at some frequencies.
struct Ball {
  solvers::modes::Modes modes;
  radiation::SourceField field;
  motion::SoundingBody body;

  Ball(int order, const std::vector<double>& frequencies, double decay_rate)
      : modes(sphere_modes(curved_sphere(fixed_radius, Vec3::Zero(), 4, 3), fixed_radius, order,
                           ka_of(frequencies))),
        field(fit(modes)) {
    body.modes = &modes;
    body.field = &field;
    body.decay_rates.assign(modes.size(), decay_rate);
  }
  Ball(const Ball&) = delete;
  Ball& operator=(const Ball&) = delete;

  static std::vector<double> ka_of(std::vector<double> frequencies) {
    for (double& value : frequencies) value *= 2 * pi * fixed_radius / modal::speed_of_sound;
    return frequencies;
  }
  static radiation::EquivalentSources fit(const solvers::modes::Modes& modes) {
    radiation::EquivalentSourcesOptions options;
    options.min_sources = options.max_sources = 100;
    return radiation::fit_equivalent_sources(modes, options);
  }
};

inline motion::Pose at(const Vec3& origin) {
  return {Eigen::Quaterniond::Identity(), origin};
}

inline motion::Impact strike(double time, const Vec3& point, const Vec3& impulse, double duration) {
  motion::Impact impact;
  impact.time = time;
  impact.bodies = {0, 1};
  impact.points = {point, point};
  impact.impulse = impulse;
  impact.normal = impulse.normalized();
  impact.duration = duration;
  return impact;
}

}  // namespace carillon::synth
