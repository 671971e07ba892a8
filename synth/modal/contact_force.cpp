#include "synth/modal/contact_force.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::synth::modal {

void check(const ContactForce& force) {
  if (!(force.duration >= 0) || !std::isfinite(force.duration)) {
    throw core::InputError(
        fmt::format("contact force: the duration must not be negative, not {} s", force.duration));
  }
  if (force.samples.empty()) return;
  if (force.samples.size() < 2 || !(force.duration > 0)) {
    throw core::InputError(fmt::format(
        "contact force: samples need a duration and be two at least, not {} samples over {} s",
        force.samples.size(), force.duration));
  }
  for (std::size_t i = 0; i < force.samples.size(); ++i) {
    if (!std::isfinite(force.samples[i])) {
      throw core::InputError(fmt::format("contact force: sample {} is not finite", i));
    }
  }
}

double impulse_of(const ContactForce& force) {
  if (force.samples.empty()) return 1;
  double sum = -(force.samples.front() + force.samples.back()) / 2;
  for (const double sample : force.samples) sum += sample;
  return sum * force.duration / static_cast<double>(force.samples.size() - 1);
}

double peak_of(const ContactForce& force) {
  if (!(force.duration > 0)) return std::numeric_limits<double>::infinity();
  if (force.samples.empty()) return 2 / force.duration;
  return core::peak(force.samples);
}

}  // namespace carillon::synth::modal
