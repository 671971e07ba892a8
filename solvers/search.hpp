#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "core/trace.hpp"
#include "solvers/eigen_solve.hpp"
#include "solvers/modes.hpp"

namespace carillon::solvers {

/// Eigenpairs that cover what a band asks for, and what is known of their completeness.
struct SearchResult {
  EigenPairs pairs;
  std::vector<std::size_t> flexible;  ///< pairs that vibrate, ascending
  int components = 0;
  /// Flexible modes below the band's top, by inertia.
  std::int64_t flexible_below_top = 0;
  bool all_verified = false;  ///< every flexible mode below the band's top is among the pairs
  double verified_below = 0;  ///< no mode below this (dimensionless) eigenvalue is missing
  ShiftedSystem shifted;  ///< what the pairs were found with; empty when nothing was to be found
};

/// First guess (mesh.faces present) of the lowest flexible frequency [Hz]: that of a plate as thick
/// as 2 volume / area and as long as the longest side, c (2 V / A) / L^2 with c = sqrt(E / rho)
/// (the constant of a free bar or plate is near 1).
double estimate_first_frequency(const TetMesh& mesh, std::span<const Elastic> regions);

/// Counts, solves and verifies: the lowest flexible modes up to the band's top, as many as
/// max_modes asks for above its bottom.
/// @throws core::SolverError  see solve_modes
/// @note Collective on comm.
SearchResult search_modes(const TetMesh& mesh, std::span<const Elastic> regions,
                          const SolveOptions& options, const System& system, MPI_Comm comm,
                          core::Trace& trace);

}  // namespace carillon::solvers
