#include "synth/diagonal_error.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"

namespace carillon::synth {

DiagonalError diagonal_error(const CoupledModes& modes, std::span<const double> eigenvalues,
                             std::span<const double> diagonal) {
  const std::size_t n = modes.eigenvalues.size();
  if (eigenvalues.size() != n || diagonal.size() != n) {
    throw core::InputError(
        fmt::format("diagonal damping: {} eigenvalues and {} decay rates for {} coupled modes",
                    eigenvalues.size(), diagonal.size(), n));
  }
  const auto squared_frequency = [](double lambda, double d) { return lambda - d * d; };
  DiagonalError error;
  error.modes = static_cast<int>(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double coupled = squared_frequency(modes.eigenvalues[i], modes.decay_rates[i]);
    const double alone = squared_frequency(eigenvalues[i], diagonal[i]);
    if (!(coupled > 0) || !(alone > 0) || !(modes.overlaps[i] > 0.5)) continue;
    ++error.matched;
    const double difference = std::abs(diagonal[i] - modes.decay_rates[i]);
    const double decay = difference > 0 ? difference / modes.decay_rates[i] : 0;
    const double cents = std::abs(600 * std::log2(alone / coupled));
    if (error.worst_decay < 0 || decay > error.decay_rate) {
      error.decay_rate = decay;
      error.worst_decay = static_cast<int>(i);
    }
    if (error.worst_pitch < 0 || cents > error.cents) {
      error.cents = cents;
      error.worst_pitch = static_cast<int>(i);
    }
  }
  return error;
}

std::string describe(const DiagonalError& error) {
  if (error.matched == 0) {
    return fmt::format("diagonal damping: none of {} modes can be compared", error.modes);
  }
  return fmt::format(
      "diagonal damping is off by up to {:.3g} % in decay rate (mode {}) and {:.3g} cents in pitch "
      "(mode {}); {} of {} modes compared",
      100 * error.decay_rate, error.worst_decay + 1, error.cents, error.worst_pitch + 1,
      error.matched, error.modes);
}

}  // namespace carillon::synth
