#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal_response.hpp"
#include "synth/resonators.hpp"
#include "synth/ring_down.hpp"
#include "synth/sampled_force.hpp"

namespace carillon::synth {

namespace {

/// All that ended partials could still have added, relative to the peak: -160 dB.
constexpr double kTail = 1e-8;
/// Where a near-critical mode, which dies within a few periods, ends: relative to its own start.
constexpr double kNearCriticalTail = 1e-17;

void check_force(const ContactForce& force) {
  if (!(force.duration >= 0) || !std::isfinite(force.duration)) {
    throw core::InputError(
        fmt::format("synthesize: contact time must not be negative, not {} s", force.duration));
  }
  if (force.samples.empty()) return;
  if (force.samples.size() < 2 || !(force.duration > 0)) {
    throw core::InputError(
        fmt::format("synthesize: a sampled force needs a duration and two samples at least, not {} "
                    "samples over {} s",
                    force.samples.size(), force.duration));
  }
  for (std::size_t i = 0; i < force.samples.size(); ++i) {
    if (!std::isfinite(force.samples[i])) {
      throw core::InputError(fmt::format("synthesize: sample {} of the force is not finite", i));
    }
  }
}

void check(const RingDown& rings, double sample_rate) {
  const auto modes = static_cast<Eigen::Index>(rings.eigenvalues.size());
  const auto rows = static_cast<Eigen::Index>(rings.readout.delays.size());
  bool fits =
      rings.decay_rates.size() == rings.eigenvalues.size() && rings.excitation.size() == modes;
  if (!rings.excitation.allFinite()) throw core::InputError("synthesize: excitation not finite");
  const Readout& readout = rings.readout;
  for (const Eigen::MatrixXd* gains :
       {&readout.displacement, &readout.velocity, &readout.acceleration}) {
    fits = fits && (gains->size() == 0 || (gains->rows() == rows && gains->cols() == modes));
    if (!gains->allFinite()) throw core::InputError("synthesize: a gain is not finite");
  }
  if (!fits) {
    throw core::InputError(fmt::format(
        "synthesize: {} eigenvalues, {} decay rates, excitation and readout ({} rows) do "
        "not belong together",
        modes, rings.decay_rates.size(), rows));
  }
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw core::InputError(
        fmt::format("synthesize: sample rate must be positive, not {} Hz", sample_rate));
  }
  for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
    // The limit keeps d^2 finite; nothing rings above it anyway.
    const double d = rings.decay_rates[i];
    if (!(d >= 0 && d < 1e100)) {
      throw core::InputError(
          fmt::format("synthesize: decay rate of mode {} must be finite and not negative, not {} "
                      "1/s",
                      i, d));
    }
    const double lambda = rings.eigenvalues[i];
    if (!(lambda >= 0) || !std::isfinite(lambda)) {
      throw core::InputError(fmt::format(
          "synthesize: eigenvalue of mode {} must be finite and not negative, not {}", i, lambda));
    }
  }
  for (const double delay : rings.readout.delays) {
    if (!(delay >= 0) || !std::isfinite(delay)) {
      throw core::InputError(
          fmt::format("synthesize: delay must be finite and not negative, not {} s", delay));
    }
  }
}

/// First sample at or after a time, at most `count`.
std::size_t first_sample(long double time, double sample_rate, std::size_t count) {
  const long double sample = std::ceil(time * sample_rate);
  return sample < static_cast<long double>(count) ? static_cast<std::size_t>(sample) : count;
}

Weights weights_of(const RingDown& rings, Eigen::Index row, Eigen::Index column) {
  const Readout& readout = rings.readout;
  const auto at = [&](const Eigen::MatrixXd& gains) {
    return gains.size() == 0 ? 0.0 : gains(row, column) * rings.excitation[column];
  };
  return {at(readout.displacement), at(readout.velocity), at(readout.acceleration)};
}

struct AudibleMode {
  Eigen::Index column;
  ModalResponse response;
};

/// One row, from the arrival of its sound on.
void synthesize_row(const std::vector<AudibleMode>& modes, const RingDown& rings, Eigen::Index row,
                    const ContactForce& force, double sample_rate, std::vector<double>& samples) {
  const double contact_time = force.duration;
  const double delay = rings.readout.delays[static_cast<std::size_t>(row)];
  const std::size_t count = samples.size();
  const long double contact_end = static_cast<long double>(delay) + contact_time;
  const std::size_t first = first_sample(delay, sample_rate, count);
  const std::size_t free = first_sample(contact_end, sample_rate, count);
  const auto time_after = [&](std::size_t sample, long double origin) {
    return std::max(0.0L, static_cast<long double>(sample) / sample_rate - origin);
  };

  ForceSchedule schedule;
  if (!force.samples.empty()) {
    schedule =
        cut_force(force, static_cast<double>(time_after(first, delay)), sample_rate, free - first);
  }
  std::vector<Partial> partials;
  for (const AudibleMode& mode : modes) {
    const Weights weights = weights_of(rings, row, mode.column);
    if (!weights.any()) continue;
    ModalResponse response = mode.response;
    if (force.samples.empty()) {
      for (std::size_t n = first; n < free; ++n) {
        const auto t = static_cast<double>(time_after(n, delay));
        samples[n] += weights.of(response.during_contact(std::min(t, contact_time)));
      }
    } else {
      const auto i = static_cast<std::size_t>(mode.column);
      const double lambda = rings.eigenvalues[i];
      const double d = rings.decay_rates[i];
      const auto during = std::span(samples).subspan(first, free - first);
      response = ModalResponse(lambda, d, add_forced_motion(lambda, d, schedule, weights, during));
    }
    if (response.near_critical()) {
      const double end = kNearCriticalTail * response.bound_after_contact(0, weights);
      for (std::size_t n = free; n < count; ++n) {
        const auto tau = static_cast<double>(time_after(n, contact_end));
        if (response.bound_after_contact(tau, weights) <= end) break;
        samples[n] += weights.of(response.after_contact(tau));
      }
      continue;
    }
    for (const Partial& partial : response.partials(weights)) partials.push_back(partial);
  }
  double peak = 0;
  for (std::size_t n = first; n < free; ++n) peak = std::max(peak, std::abs(samples[n]));
  add_partials(partials, time_after(free, contact_end), sample_rate, kTail, peak,
               std::span(samples).subspan(free));
}

}  // namespace

std::vector<float> synthesize(const RingDown& rings, const ContactForce& force, double sample_rate,
                              std::size_t count, int* dropped) {
  check_force(force);
  check(rings, sample_rate);
  std::vector<AudibleMode> modes;
  for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
    const ModalResponse response(rings.eigenvalues[i], rings.decay_rates[i], force.duration);
    if (response.damped_frequency() < std::numbers::pi * sample_rate) {
      modes.push_back({static_cast<Eigen::Index>(i), response});
    }
  }
  if (dropped != nullptr) *dropped = static_cast<int>(rings.eigenvalues.size() - modes.size());

  const std::size_t rows = rings.readout.delays.size();
  std::vector<float> result;
  result.reserve(rows * count);
  std::vector<double> samples;
  for (std::size_t row = 0; row < rows; ++row) {
    samples.assign(count, 0.0);
    synthesize_row(modes, rings, static_cast<Eigen::Index>(row), force, sample_rate, samples);
    for (const double sample : samples) result.push_back(static_cast<float>(sample));
  }
  return result;
}

}  // namespace carillon::synth
