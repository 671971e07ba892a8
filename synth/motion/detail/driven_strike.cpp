#include "synth/motion/detail/driven_strike.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "synth/modal/modal_response.hpp"
#include "synth/modal/sampled_force.hpp"

namespace carillon::synth::motion {

namespace {

constexpr double max_contact_time = 1e5;  ///< [samples]
constexpr double longest_wait = 1e15;

/// Of a strike of unit impulse at t within its duration [1/s].
double force_at(const modal::ContactForce& force, double t) {
  if (force.samples.empty()) return modal::contact_force(force.duration, t);
  const double place = t / force.duration * static_cast<double>(force.samples.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(place), force.samples.size() - 2);
  const double rest = place - static_cast<double>(k);
  return force.samples[k] + rest * (force.samples[k + 1] - force.samples[k]);
}

/// A mode at rest under a strike: what it does at samples in contact, and its motion at the end.
struct Pushed {
  std::vector<double> displacement, velocity, force_rate;
  modal::ModalMotion end;
};

Pushed push(double eigenvalue, double decay_rate, const modal::ContactForce& force,
            const modal::ForceSchedule& schedule, double first, double sample_rate,
            std::size_t count) {
  Pushed pushed;
  pushed.displacement.assign(count, 0.0);
  pushed.velocity.assign(count, 0.0);
  pushed.force_rate.assign(count, 0.0);
  if (!force.samples.empty()) {
    modal::add_forced_motion(eigenvalue, decay_rate, schedule, {.displacement = 1},
                             pushed.displacement);
    pushed.end = modal::add_forced_motion(eigenvalue, decay_rate, schedule, {.velocity = 1},
                                          pushed.velocity);
    return pushed;
  }
  const modal::ModalResponse response(eigenvalue, decay_rate, force.duration);
  for (std::size_t n = 0; n < count; ++n) {
    const double t = first + static_cast<double>(n) / sample_rate;
    const modal::ModalMotion motion = response.during_contact(std::min(t, force.duration));
    pushed.displacement[n] = motion.displacement;
    pushed.velocity[n] = motion.velocity;
    pushed.force_rate[n] = motion.force_rate;
  }
  pushed.end = response.after_contact(0);
  return pushed;
}

}  // namespace

DrivenStrike driven_strike(std::span<const double> eigenvalues, std::span<const double> decay_rates,
                           const Eigen::VectorXd& excitation, const modal::ContactForce& force,
                           double delay, double sample_rate) {
  modal::check(force);
  if (!(delay >= 0 && delay * sample_rate < longest_wait)) {
    throw core::InputError(fmt::format("driven modes: a strike cannot begin after {} s", delay));
  }
  if (!(force.duration * sample_rate <= max_contact_time)) {
    throw core::InputError(
        fmt::format("driven modes: a contact of {:.4g} s is longer than {:.4g} s", force.duration,
                    max_contact_time / sample_rate));
  }
  const long double start = static_cast<long double>(delay) * sample_rate;
  const long double stop = (static_cast<long double>(delay) + force.duration) * sample_rate;
  const long double first = std::ceil(start), free = std::ceil(stop);
  const double begin = static_cast<double>((first - start) / sample_rate);
  const double rest = static_cast<double>((free - stop) / sample_rate);
  const auto count = static_cast<std::size_t>(free - first);
  const modal::ForceSchedule schedule = force.samples.empty()
                                            ? modal::ForceSchedule{}
                                            : modal::cut_force(force, begin, sample_rate, count);
  const auto modes = static_cast<Eigen::Index>(eigenvalues.size());
  const auto samples = static_cast<Eigen::Index>(count);
  DrivenStrike strike;
  strike.first = static_cast<std::uint64_t>(first);
  strike.free = static_cast<std::uint64_t>(free);
  strike.excitation = excitation;
  strike.force.resize(samples);
  for (Eigen::Index n = 0; n < samples; ++n) {
    const double t = begin + static_cast<double>(n) / sample_rate;
    strike.force[n] = force_at(force, std::min(t, force.duration));
  }
  strike.displacement.resize(modes, samples);
  strike.velocity.resize(modes, samples);
  strike.force_rate.resize(modes, samples);
  strike.end_displacement.resize(modes);
  strike.end_velocity.resize(modes);
  for (Eigen::Index i = 0; i < modes; ++i) {
    const auto mode = static_cast<std::size_t>(i);
    const double by = excitation[i];
    const double lambda = eigenvalues[mode], d = decay_rates[mode];
    const Pushed pushed = push(lambda, d, force, schedule, begin, sample_rate, count);
    const auto row = [&](const std::vector<double>& values) {
      return by * Eigen::Map<const Eigen::RowVectorXd>(values.data(), samples);
    };
    strike.displacement.row(i) = row(pushed.displacement);
    strike.velocity.row(i) = row(pushed.velocity);
    strike.force_rate.row(i) = row(pushed.force_rate);
    const modal::ModalMotion at_free =
        modal::ModalResponse(lambda, d, pushed.end).after_contact(rest);
    strike.end_displacement[i] = by * at_free.displacement;
    strike.end_velocity[i] = by * at_free.velocity;
  }
  return strike;
}

}  // namespace carillon::synth::motion
