#include "synth/modal/row_response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/sampled_force.hpp"

namespace carillon::synth::modal {

namespace {

std::complex<double> carried(const Partial& partial, long double time) {
  if (time == 0) return partial.amplitude;
  return partial.amplitude * exponential(partial.decay_rate, partial.angular_frequency, time);
}

}  // namespace

Weights weights_of(const Readout& readout, Eigen::Index row, Eigen::Index mode, double excitation) {
  const auto at = [&](const Eigen::MatrixXd& gains) {
    return gains.size() == 0 ? 0.0 : gains(row, mode) * excitation;
  };
  return {at(readout.displacement), at(readout.velocity), at(readout.acceleration),
          at(readout.force_rate)};
}

Resonances make_resonances(std::span<const double> eigenvalues, std::span<const double> decay_rates,
                           double sample_rate) {
  if (eigenvalues.size() != decay_rates.size()) {
    throw core::InputError(fmt::format("synthesize: {} eigenvalues and {} decay rates",
                                       eigenvalues.size(), decay_rates.size()));
  }
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw core::InputError(
        fmt::format("synthesize: sample rate must be positive, not {} Hz", sample_rate));
  }
  Resonances resonances;
  resonances.sample_rate = sample_rate;
  resonances.eigenvalues.assign(eigenvalues.begin(), eigenvalues.end());
  resonances.decay_rates.assign(decay_rates.begin(), decay_rates.end());
  resonances.modes.reserve(eigenvalues.size());
  resonances.rotations.reserve(eigenvalues.size());
  for (std::size_t i = 0; i < eigenvalues.size(); ++i) {
    // The limit keeps d^2 finite; nothing rings above it anyway.
    if (!(decay_rates[i] >= 0 && decay_rates[i] < 1e100)) {
      throw core::InputError(
          fmt::format("synthesize: decay rate of mode {} must be finite and not negative, not {} "
                      "1/s",
                      i, decay_rates[i]));
    }
    if (!(eigenvalues[i] >= 0) || !std::isfinite(eigenvalues[i])) {
      throw core::InputError(
          fmt::format("synthesize: eigenvalue of mode {} must be finite and not negative, not {}",
                      i, eigenvalues[i]));
    }
    const ModalResponse response(eigenvalues[i], decay_rates[i], 0);
    if (response.damped_frequency() >= std::numbers::pi * sample_rate) continue;
    const std::size_t first = resonances.rotations.size();
    if (!response.near_critical()) {
      for (const Partial& pole : response.poles()) {
        if (pole.amplitude == 0.0) continue;
        resonances.rotations.push_back(
            make_rotation(pole.decay_rate, pole.angular_frequency, sample_rate));
      }
    }
    resonances.modes.push_back({i, first, resonances.rotations.size() - first});
  }
  return resonances;
}

void respond(const Resonances& resonances, const Readout& readout, Eigen::Index row,
             const Eigen::VectorXd& excitation, const ContactForce& force,
             const StrikeTiming& timing, RowResponse& response) {
  response.begin.assign(resonances.rotations.size(), 0);
  response.end.assign(resonances.rotations.size(), 0);
  response.direct.assign(timing.contact_samples, 0);
  response.forced = {};
  response.near_critical.clear();
  const bool sampled = !force.samples.empty();
  ForceSchedule schedule;
  if (sampled) {
    schedule = cut_force(force, static_cast<double>(timing.first), resonances.sample_rate,
                         timing.contact_samples);
  }
  for (const Resonances::Mode& mode : resonances.modes) {
    const auto column = static_cast<Eigen::Index>(mode.index);
    const Weights weights = weights_of(readout, row, column, excitation[column]);
    if (!weights.any()) continue;
    const double lambda = resonances.eigenvalues[mode.index];
    const double d = resonances.decay_rates[mode.index];
    const ModalResponse motion =
        sampled ? ModalResponse(lambda, d,
                                add_forced_motion(lambda, d, schedule, weights, response.direct))
                : ModalResponse(lambda, d, force.duration);
    if (motion.contact_splits()) {
      const std::array<Partial, 2> partials = motion.contact_partials(weights);
      for (std::size_t k = 0; k < mode.rotations; ++k) {
        response.begin[mode.rotation + k] = carried(partials[k], timing.first);
        response.end[mode.rotation + k] = -carried(partials[k], timing.free);
      }
      const ForcedMotion forced = motion.forced_motion(weights);
      response.forced.constant += forced.constant;
      response.forced.turning += forced.turning;
      continue;
    }
    for (std::size_t n = 0; !sampled && n < timing.contact_samples; ++n) {
      const long double t = timing.first + static_cast<long double>(n) / resonances.sample_rate;
      response.direct[n] +=
          weights.of(motion.during_contact(std::min(static_cast<double>(t), force.duration)));
    }
    if (motion.near_critical()) {
      ModalMotion start = motion.after_contact(static_cast<double>(timing.free));
      start.displacement *= excitation[column];
      start.velocity *= excitation[column];
      start.acceleration *= excitation[column];
      response.near_critical.push_back({mode.index, weights_of(readout, row, column, 1), start});
      continue;
    }
    const std::array<Partial, 2> partials = motion.partials(weights);
    for (std::size_t k = 0; k < mode.rotations; ++k) {
      response.end[mode.rotation + k] = carried(partials[k], timing.free);
    }
  }
  if (response.forced.turning != 0.0) {
    const long double turns = 2 * std::numbers::pi_v<long double> / force.duration;
    response.forced.turning *= exponential(0, turns, timing.first);
  }
}

}  // namespace carillon::synth::modal
