#include "synth/modal/heard_modes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "synth/modal/hearing.hpp"

namespace carillon::synth::modal {

using Complex = std::complex<double>;

std::vector<RingingMode> ringing_modes(const RingDown& rings, const ContactForce& force,
                                       double sample_rate) {
  std::vector<RingingMode> modes(rings.eigenvalues.size());
  for (std::size_t i = 0; i < modes.size(); ++i) {
    RingingMode& mode = modes[i];
    const double d = rings.decay_rates[i];
    mode.pulse.emplace(rings.eigenvalues[i], d, force.samples.empty() ? force.duration : 0);
    mode.drifts = rings.eigenvalues[i] == 0 && d == 0;
    const double damped = mode.pulse->damped_frequency();
    if (damped >= std::numbers::pi * sample_rate) {
      mode.kind = MotionKind::above_band;
      continue;
    }
    if (damped == 0 || mode.pulse->near_critical()) continue;
    mode.kind = MotionKind::ringing;
    mode.pole = {-d, damped};
    mode.frequency = damped / (2 * std::numbers::pi);
    mode.bark = bark(mode.frequency);
    if (!force.samples.empty()) {
      mode.sampled.emplace(rings.eigenvalues[i], d, force);
    }
  }
  return modes;
}

RowTimes row_times(double delay, const ContactForce& force, double sample_rate, std::size_t count) {
  const auto sample = [&](long double time) {
    const long double n = std::ceil(time * sample_rate);
    return n < static_cast<long double>(count) ? static_cast<std::size_t>(n) : count;
  };
  const long double end = static_cast<long double>(delay) + force.duration;
  RowTimes times{delay, sample(delay), sample(end), 0};
  times.offset =
      std::max(0.0, static_cast<double>(static_cast<long double>(times.free) / sample_rate - end));
  return times;
}

HeardMode hear_mode(const RingingMode& mode, const Weights& weights, double duration) {
  HeardMode heard;
  heard.weights = weights;
  if (mode.kind != MotionKind::ringing || !weights.any()) return heard;
  if (mode.sampled) {
    const ModalMotion end = mode.sampled->at(duration);
    // q = Re(B exp(s tau)) with these starting values.
    const Complex s = mode.pole;
    const Complex q(end.displacement, -(end.velocity - s.real() * end.displacement) / s.imag());
    heard.amplitude =
        q * (weights.displacement + s * (weights.velocity + s * weights.acceleration));
  } else {
    heard.amplitude = mode.pulse->partials(weights)[0].amplitude;
  }
  const double rate = -2 * mode.pole.real();
  const double seconds = rate > 0 ? -std::expm1(-rate * kIntegrationTime) / rate : kIntegrationTime;
  heard.loudness = std::norm(heard.amplitude) / 2 * seconds / kIntegrationTime;
  return heard;
}

void hear_contact(const RingingMode& mode, const RowTimes& times, double duration,
                  double sample_rate, HeardMode& heard) {
  if (!heard.contact.empty()) return;
  for (std::size_t n = times.first; n < times.free; ++n) {
    const double t = std::clamp(static_cast<double>(n) / sample_rate - times.delay, 0.0, duration);
    const double value = heard.weights.of(mode.during(t));
    heard.contact.push_back(value);
    heard.contact_peak = std::max(heard.contact_peak, std::abs(value));
    heard.contact_energy += value * value;
  }
}

SampledPartial partial_of(const RingingMode& mode, const HeardMode& heard, const RowTimes& times,
                          double sample_rate) {
  return {heard.amplitude * std::exp(mode.pole * times.offset), mode.pole / sample_rate};
}

}  // namespace carillon::synth::modal
