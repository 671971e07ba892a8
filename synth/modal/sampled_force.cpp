#include "synth/modal/sampled_force.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "synth/modal/detail/phi_functions.hpp"

namespace carillon::synth::modal {

namespace {

/// Times nearer than this fraction of an output sample are one: a phase error below 1e-10 rad.
constexpr double same_time = 1e-11;

}  // namespace

LinearForceStep linear_force_step(double eigenvalue, double decay_rate, double length) {
  const double omega = std::sqrt(eigenvalue);
  const double split = std::sqrt(std::abs(decay_rate - omega)) * std::sqrt(decay_rate + omega);
  const bool oscillates = decay_rate < omega;
  // Fundamental solutions, as in ModalResponse::after_contact.
  const double fast = oscillates ? omega : decay_rate + split;
  const double slow = oscillates ? decay_rate : fast > 0 ? eigenvalue / fast : 0;
  const double decay = std::exp(-slow * length);
  double slope = 0;
  double slope_rate = 0;
  double start = 0;
  if (oscillates) {
    const double angle = split * length;
    const double sinc = angle < 1e-4 ? 1 - angle * angle / 6 : std::sin(angle) / angle;
    slope = decay * length * sinc;
    slope_rate = decay * std::cos(angle) - decay_rate * slope;
    start = decay * std::cos(angle) + decay_rate * slope;
  } else {
    slope = decay * length * phi1(-2 * split * length);
    slope_rate = decay - fast * slope;
    start = decay + slow * slope;
  }
  // Response to a constant force 1, and to one that rises from 0 to 1: divided differences of
  // l^2 phi1 and l^2 phi2 between the poles times the length l.
  double constant = 0;
  double ramp = 0;
  if (fast * length <= 1) {
    // Power series by complete homogeneous polynomials of the poles, which ask nothing of their
    // distance.
    const double sum = -2 * decay_rate * length;
    const double product = eigenvalue * length * length;
    double last = 0;
    double power = 1;
    double factor = 0.5;  // 1 / (n + 1)!
    for (int n = 1; n <= 22; ++n) {
      constant += power * factor;
      factor /= n + 2;
      ramp += power * factor;
      const double next = sum * power - product * last;
      last = power;
      power = next;
    }
    constant *= length * length;
    ramp *= length * length;
  } else if (oscillates || split <= 0.1 * decay_rate) {
    // The equation of motion, integrated once and twice.
    constant = (1 - start) / eigenvalue;
    ramp = (length - slope - 2 * decay_rate * constant) / (eigenvalue * length);
  } else {
    const double distance = 2 * split * length;
    constant = length * length * (phi1(-slow * length) - phi1(-fast * length)) / distance;
    ramp = length * length * (phi2(-slow * length) - phi2(-fast * length)) / distance;
  }
  const double rise = length > 0 ? constant / length : 0;
  return {start, slope, constant - ramp, ramp, -eigenvalue * slope, slope_rate, slope - rise, rise};
}

ForceSchedule cut_force(const ContactForce& force, double first, double sample_rate,
                        std::size_t count) {
  ForceSchedule schedule;
  const std::size_t pieces = force.samples.size() - 1;
  const double step = force.duration / static_cast<double>(pieces);
  const double same = same_time / sample_rate;
  const auto knot = [&](std::size_t k) {
    return k == pieces ? force.duration : static_cast<double>(k) * step;
  };
  const auto sample_time = [&](std::size_t n) {
    return std::min(first + static_cast<double>(n) / sample_rate, force.duration);
  };
  const auto length_index = [&](double length) {
    // The last few are enough: steps that go together repeat in a short cycle.
    const std::size_t known = schedule.lengths.size();
    for (std::size_t i = known; i-- > (known > 8 ? known - 8 : 0);) {
      if (std::abs(schedule.lengths[i] - length) <= same) return static_cast<std::uint32_t>(i);
    }
    schedule.lengths.push_back(length);
    return static_cast<std::uint32_t>(known);
  };
  schedule.stretches.reserve(pieces + count);
  double time = 0;
  double value = force.samples[0];
  std::size_t sample = 0;
  for (std::size_t k = 0; k < pieces;) {
    const double bend = knot(k + 1);
    const bool samples_next = sample < count && sample_time(sample) <= bend + same;
    const bool bends = !samples_next || sample_time(sample) >= bend - same;
    const double end = bends ? bend : std::max(time, sample_time(sample));
    const double fraction = bends ? 1 : std::clamp((end - knot(k)) / step, 0.0, 1.0);
    const double end_value =
        force.samples[k] + fraction * (force.samples[k + 1] - force.samples[k]);
    schedule.stretches.push_back({length_index(end - time), samples_next, value, end_value});
    time = end;
    value = end_value;
    if (samples_next) ++sample;
    if (bends) ++k;
  }
  return schedule;
}

ModalMotion add_forced_motion(double eigenvalue, double decay_rate, const ForceSchedule& schedule,
                              const Weights& weights, std::span<double> samples) {
  std::vector<LinearForceStep> steps;
  steps.reserve(schedule.lengths.size());
  for (const double length : schedule.lengths) {
    steps.push_back(linear_force_step(eigenvalue, decay_rate, length));
  }
  // Weights of q, v and the force, with q'' = F - 2 d v - lambda q.
  const double of_q = weights.displacement - eigenvalue * weights.acceleration;
  const double of_v = weights.velocity - 2 * decay_rate * weights.acceleration;
  double q = 0;
  double v = 0;
  auto sample = samples.begin();
  for (const ForceSchedule::Stretch& stretch : schedule.stretches) {
    const LinearForceStep& step = steps[stretch.length];
    const double next =
        step.qq * q + step.qv * v + (step.q_begin * stretch.begin + step.q_end * stretch.end);
    v = step.vq * q + step.vv * v + (step.v_begin * stretch.begin + step.v_end * stretch.end);
    q = next;
    if (stretch.samples_end && sample != samples.end()) {
      *sample++ += of_q * q + of_v * v + weights.acceleration * stretch.end;
    }
  }
  return {q, v, -2 * decay_rate * v - eigenvalue * q};
}

SampledResponse::SampledResponse(double eigenvalue, double decay_rate, const ContactForce& force)
    : eigenvalue_(eigenvalue), decay_rate_(decay_rate), force_(force) {
  check(force);
  if (force.samples.empty()) throw core::InputError("a sampled force has no samples");
  const std::size_t pieces = force.samples.size() - 1;
  step_ = force.duration / static_cast<double>(pieces);
  const LinearForceStep whole = linear_force_step(eigenvalue, decay_rate, step_);
  knots_.reserve(pieces + 1);
  knots_.push_back({});
  for (std::size_t k = 0; k < pieces; ++k) {
    const double begin = force.samples[k];
    const double end = force.samples[k + 1];
    const Knot next = after(whole, knots_.back(), begin, end);
    knots_.push_back({next.q, next.v, knots_.back().impulse + step_ * (begin + end) / 2});
  }
}

SampledResponse::Knot SampledResponse::after(const LinearForceStep& step, const Knot& from,
                                             double begin, double end) {
  return {step.qq * from.q + step.qv * from.v + (step.q_begin * begin + step.q_end * end),
          step.vq * from.q + step.vv * from.v + (step.v_begin * begin + step.v_end * end), 0};
}

SampledResponse::Place SampledResponse::place(double t) const {
  const std::size_t k = std::min(static_cast<std::size_t>(t / step_), knots_.size() - 2);
  const double rest = std::clamp(t - static_cast<double>(k) * step_, 0.0, step_);
  const double begin = force_.samples[k];
  return {k, rest, begin + rest / step_ * (force_.samples[k + 1] - begin)};
}

double SampledResponse::impulse(double t) const {
  if (t <= 0) return 0;
  if (t >= force_.duration) return knots_.back().impulse;
  const Place at = place(t);
  return knots_[at.piece].impulse + at.rest * (force_.samples[at.piece] + at.force) / 2;
}

ModalMotion SampledResponse::at(double t) const {
  if (!(t > 0)) return {};
  Knot now;
  double force = 0;
  if (t > force_.duration) {
    const double length = t - force_.duration;
    now = after(linear_force_step(eigenvalue_, decay_rate_, length), knots_.back(), 0, 0);
  } else {
    const Place at = place(t);
    force = at.force;
    now = after(linear_force_step(eigenvalue_, decay_rate_, at.rest), knots_[at.piece],
                force_.samples[at.piece], force);
  }
  return {now.q, now.v, force - 2 * decay_rate_ * now.v - eigenvalue_ * now.q};
}

}  // namespace carillon::synth::modal
