#include "synth/support/diagonal_error.hpp"

#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <vector>

#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::synth::support {

namespace {

/// Counts a mode and keeps the largest errors.
void compare(DiagonalError& error, std::size_t mode, double decay, double cents) {
  ++error.matched;
  if (error.worst_decay < 0 || decay > error.decay_rate) {
    error.decay_rate = decay;
    error.worst_decay = static_cast<int>(mode);
  }
  if (error.worst_pitch < 0 || cents > error.cents) {
    error.cents = cents;
    error.worst_pitch = static_cast<int>(mode);
  }
}

}  // namespace

DiagonalError diagonal_error(const CoupledModes& modes, std::span<const double> eigenvalues,
                             std::span<const double> diagonal) {
  const std::size_t n = modes.overlaps.size();
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
    const double difference = std::abs(diagonal[i] - modes.decay_rates[i]);
    const double decay = difference > 0 ? difference / modes.decay_rates[i] : 0;
    compare(error, i, decay, std::abs(600 * std::log2(alone / coupled)));
  }
  return error;
}

DiagonalError estimate_diagonal_error(std::span<const double> eigenvalues,
                                      std::span<const double> diagonal,
                                      const Eigen::MatrixXd& dashpots) {
  using Complex = std::complex<double>;
  const std::size_t n = eigenvalues.size();
  if (diagonal.size() != n || dashpots.rows() < static_cast<Eigen::Index>(n)) {
    throw core::InputError(
        fmt::format("diagonal damping: {} eigenvalues, {} decay rates, dashpots of {} coordinates",
                    n, diagonal.size(), dashpots.rows()));
  }
  const auto coordinates = static_cast<std::size_t>(dashpots.rows());
  std::vector<double> twice_d(coordinates), lambda(coordinates, 0.0);
  for (std::size_t j = 0; j < coordinates; ++j) {
    twice_d[j] = j < n ? 2 * diagonal[j] : dashpots.row(static_cast<Eigen::Index>(j)).squaredNorm();
    if (j < n) lambda[j] = eigenvalues[j];
  }
  DiagonalError error;
  error.modes = static_cast<int>(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double squared = lambda[i] - diagonal[i] * diagonal[i];
    if (!(squared > 0)) continue;
    const Complex s(-diagonal[i], std::sqrt(squared));
    const Complex factor = s * s / (2.0 * s + twice_d[i]);
    const Eigen::VectorXd g = dashpots * dashpots.row(static_cast<Eigen::Index>(i)).transpose();
    Complex moved = 0;
    for (std::size_t j = 0; j < coordinates; ++j) {
      const double coupling = g[static_cast<Eigen::Index>(j)];
      if (j == i || coupling == 0) continue;
      const Complex p = s * (s + twice_d[j]) + lambda[j];
      const Complex push = factor * (coupling * coupling);
      if (push == 0.0) continue;
      const Complex root = std::sqrt(p * p + 4.0 * (2.0 * s + twice_d[j]) * push);
      // The smaller of the two solutions: the pole that is mode i without coupling.
      moved += 2.0 * push / (std::abs(p + root) > std::abs(p - root) ? p + root : p - root);
    }
    const double decay = moved == 0.0 ? 0 : std::abs(moved.real()) / diagonal[i];
    const double pitch = std::abs(s.imag() + moved.imag()) / s.imag();
    compare(error, i, decay, std::abs(core::cents(pitch)));
  }
  return error;
}

}  // namespace carillon::synth::support
