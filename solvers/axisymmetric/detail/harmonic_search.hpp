#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/trace.hpp"
#include "solvers/axisymmetric/detail/harmonic_forms.hpp"
#include "solvers/elements/elastic.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::solvers::axisymmetric {

/// What is known of one harmonic's modes below a frequency.
struct Harmonic {
  int n = 0;
  std::int64_t counted = 0;    ///< flexible modes below the frequency by inertia, each once
  std::vector<double> values;  ///< eigenvalues found, dimensionless, ascending; some beyond
  Eigen::MatrixXd vectors;     ///< unknowns x values, M-normalised
  std::vector<double> residuals;
  double orthonormality = 0;
  modes::EigenSolver solver = modes::EigenSolver::block_lanczos;  ///< that found them
  int rigid = 0;                                                  ///< recognised by projection
  /// Nothing is missing below this dimensionless eigenvalue (infinite: all that was counted).
  double verified_below = std::numeric_limits<double>::infinity();

  std::int64_t multiplicity() const { return n == 0 ? 1 : 2; }
};

/// Wave number [rad/m] of the slowest wave at a frequency [Hz]: bending waves of a plate half as
/// thick as the body's wall, or Rayleigh's surface wave, taken a tenth too slow.
double largest_wave_number(const mesh::MeridianSize& size, const elements::Elastic& material,
                           double frequency);

/// First guess of the lowest flexible frequency [Hz]: estimate_first_frequency()'s formula.
double estimate_first_frequency(const mesh::MeridianSize& size, const elements::Elastic& material);

/// Counts the modes of n = 0, 1, 2, ... below a frequency. The last harmonic has none, nor have the
/// two before it, and it has more waves around than the slowest wave finds room for at the largest
/// radius: beyond, every wave is evanescent and frequencies only grow.
/// @throws core::SolverError  fewer modes than rigid ones
std::vector<Harmonic> count_harmonics(const HarmonicForms& forms, const mesh::MeridianSize& size,
                                      double frequency, core::Trace& trace);

/// Finds the modes that were counted, with rigid motions told apart by projection; checks
/// residuals and compares with the count, a second and third time with another start where modes
/// are missing.
/// @param frequency  that was counted at [Hz]
/// @param estimate   of the lowest flexible frequency [Hz]
/// @throws core::SolverError  no convergence, residuals as in solve_modes, or rigid motions missing
void solve_harmonic(const HarmonicForms& forms, double frequency, double estimate, double tolerance,
                    Harmonic& harmonic, core::Trace& trace);

/// Eigenvalues of a harmonic's counted modes on finer cells, dimensionless there, ascending: one
/// step of inverse iteration from the modes, then Rayleigh and Ritz's procedure on both.
/// @param finer     the same cells as `forms`, of a higher order
/// @param harmonic  its modes on `forms`
/// @param estimate  of the lowest flexible frequency [Hz]
std::vector<double> next_order_values(const HarmonicForms& finer, const HarmonicForms& forms,
                                      const Harmonic& harmonic, double estimate);

}  // namespace carillon::solvers::axisymmetric
