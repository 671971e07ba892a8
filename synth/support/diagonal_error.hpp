#pragma once

#include <limits>
#include <span>
#include <string>

#include "synth/support/coupled_modes.hpp"

namespace carillon::synth::support {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// How far the diagonal answer (d_i + G_ii / 2 at the undamped frequency) is from the coupled one.
struct DiagonalError {
  int matched = 0;  ///< modes compared: both oscillate, and share more than half their energy
  int modes = 0;    ///< of so many
  /// Largest |d_diagonal - d_coupled| / d_coupled; NaN where no mode can be compared.
  double decay_rate = unknown;
  double cents = unknown;  ///< largest distance of damped frequencies [cents]; likewise
  int worst_decay = -1;    ///< mode of the largest error in decay rate; -1: none compared
  int worst_pitch = -1;    ///< mode of the largest error in pitch
};

/// @param diagonal  decay rates of the diagonal answer, n (add_support_damping())
/// @throws InputError  sizes that do not match
DiagonalError diagonal_error(const CoupledModes& modes, std::span<const double> eigenvalues,
                             std::span<const double> diagonal);

/// An estimate of the same without solving the coupled problem, by perturbation: with the diagonal
/// poles s_i = -d_i + i sqrt(lambda_i - d_i^2) and P_j(s) = s^2 + 2 d_j s + lambda_j, the pole of
/// mode i moves by the sum over j of delta_ij, where delta_ij (P_j(s_i) + delta_ij P_j'(s_i)) =
/// s_i^2 G_ij^2 / (2 s_i + 2 d_i), so that equal poles repel each other by no more than they are
/// coupled. In order of the force it is right where it is small; where it is not, it says that the
/// diagonal answer is not to be trusted. `matched` is the number of modes that oscillate; decay
/// rates are relative to the diagonal ones.
/// @param diagonal  d_j, n
/// @param dashpots  L, n rows, then one for each rigid coordinate (whose P is s^2 + G_jj s)
/// @throws InputError  sizes that do not match
DiagonalError estimate_diagonal_error(std::span<const double> eigenvalues,
                                      std::span<const double> diagonal,
                                      const Eigen::MatrixXd& dashpots);

}  // namespace carillon::synth::support
