#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "solvers/modes/modes.hpp"
#include "synth/surface/rigid_body.hpp"

namespace carillon::synth::support {

/// A body that springs hold: its own modes, in place of those of the free body.
struct HeldModes {
  solvers::modes::Modes modes;
  std::vector<double> decay_rates;  ///< what the free modes' damping takes from them [1/s]
};

/// Modes of a body on springs, in the space of its free modes and of its motion as a whole
/// (Rayleigh and Ritz): the eigenpairs of diag(lambda, 0) + S S^T. Frequencies are never too low,
/// and fall towards the true ones as free modes are added; pitch errors, where the free modes have
/// some, have their share of those and an estimate of what modes above the free ones would change.
/// Damping is that
/// of the free modes, V^T diag(d) V, of which the diagonal is kept; the body as a whole has none.
/// Modes beyond the band of the free ones are left out, below (what springs do not hold) and above.
///
/// @param decay_rates  of the free modes [1/s], n
/// @param springs      S [s^-1]: contact_factor() with `rigid` times the root of the stiffness
///                     [N/m]; n + 6 rows, any number of columns
/// @throws InputError   sizes that do not match, values that are not finite
/// @throws SolverError  LAPACK finds no eigenvalues
HeldModes hold_modes(const solvers::modes::Modes& free, std::span<const double> decay_rates,
                     const surface::RigidBody& rigid, const Eigen::MatrixXd& springs);

}  // namespace carillon::synth::support
