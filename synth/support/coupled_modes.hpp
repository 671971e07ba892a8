#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "synth/modal/ring_down.hpp"

namespace carillon::synth::support {

/// A damped body whose modes are coupled by what holds it, q'' + (2 diag(d) + L L^T) q' +
/// diag(lambda) q = f, as second-order oscillators, each of one conjugate pair of poles or of two
/// real ones. Of n modes, oscillator i < n carries on mode i: pairs are matched by their fraction
/// of energy. Rigid coordinates (lambda = 0) have a velocity and no place, one pole each;
/// oscillators beyond n, at most half as many, are of such poles: the slow creep of the body as a
/// whole.
struct CoupledModes {
  std::vector<double> eigenvalues;  ///< |s|^2, or s1 s2 of two real poles [rad^2/s^2], >= n
  std::vector<double> decay_rates;  ///< -Re s, or -(s1 + s2) / 2 [1/s], >= n, never negative
  /// Share of mode i in the energy of oscillator i's eigenvectors, 0 to 1; n values.
  std::vector<double> overlaps;
  /// Modes that the supports touch; the others (nothing beyond rounding) stay as they are.
  std::vector<int> coupled;
  /// Relative increase of L L^T by which two poles that fall together were kept apart; 0 as a rule.
  double perturbation = 0;

  /// Eigenvectors of the coupled part and their factors, for coupled_ring_down().
  struct Vectors;
  std::shared_ptr<const Vectors> vectors;
};

/// Modes that couple() takes: 600 are 1,206 rows and some seconds, and time grows with the cube.
inline constexpr std::size_t max_coupled_modes = 600;

/// Solves the damped problem in modal coordinates by its first-order form of 2 n rows, and one for
/// each rigid coordinate (LAPACK dgeev). Velocities are turned so that the dashpots act on as few
/// coordinates as they have columns, strongest first: slow poles then keep their digits beside a
/// dashpot of 1e12 N s/m.
///
/// A pole of two equal eigenvectors (critical damping, two modes at an exceptional point) has no
/// expansion in eigenvectors. Where their condition exceeds 1e9, L L^T is raised by 1e-6 to 1e-4 of
/// itself, which parts them and changes the sound by no more than that.
///
/// @param eigenvalues  lambda > 0, n
/// @param decay_rates  d without supports [1/s], n
/// @param dashpots     L [s^-1/2], as dashpots() makes it: n rows, then one for each rigid
///                     coordinate if the body is free to move as a whole
/// @return nothing when the eigenvectors stay dependent all the same: the caller keeps the diagonal
///         answer
/// @throws InputError   sizes that do not match, a mode without stiffness (lambda = 0), a value
///                      that is negative or not finite, more than max_coupled_modes modes that the
///                      supports touch
/// @throws SolverError  LAPACK finds no eigenvalues
std::optional<CoupledModes> couple(std::span<const double> eigenvalues,
                                   std::span<const double> decay_rates,
                                   const Eigen::MatrixXd& dashpots);

/// A ring-down of the uncoupled modes, as a sum over the coupled body's oscillators: the same
/// output C0 q + C1 q' + C2 q'' from the same force, exactly (the part of q'' that follows the
/// force at once included). Excitations become 1 and gains carry the strike. Neither does the
/// strike push rigid coordinates nor does the readout hear them; what they do to the modes is
/// there.
/// @param rings  coordinates are those that were coupled; its decay rates are not used
/// @throws InputError  sizes that do not match
modal::RingDown coupled_ring_down(const CoupledModes& modes, const modal::RingDown& rings);

}  // namespace carillon::synth::support
