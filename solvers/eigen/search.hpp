#pragma once

#include <mpi.h>

#include <functional>
#include <span>
#include <vector>

#include "core/trace.hpp"
#include "solvers/eigen/eigen_solve.hpp"
#include "solvers/eigen/slicing.hpp"
#include "solvers/eigen/solve_modes.hpp"

namespace carillon::solvers::eigen {

/// Eigenpairs that cover what a band asks for, and what is known of their completeness.
struct SearchResult {
  EigenPairs pairs;
  std::vector<std::size_t> flexible;  ///< pairs that vibrate, ascending
  int components = 0;
  bool counted = false;  ///< inertia vouches for what is said of completeness
  /// Flexible modes below the band's top: by inertia, or those that were seen.
  std::int64_t flexible_below_top = 0;
  bool all_verified = false;  ///< every flexible mode below the band's top is among the pairs
  double verified_below = 0;  ///< no mode below this (dimensionless) eigenvalue is missing
  modes::EigenSolver eigen_solver = modes::EigenSolver::block_lanczos;  ///< the one that was used
  modes::LinearSolver linear_solver = modes::LinearSolver::direct;      ///< likewise
  std::int64_t spare_memory = 0;  ///< [byte] left of the limit beside all that this holds
  ShiftedSystem shifted;  ///< what the pairs were found with; empty when nothing was to be found
};

/// What a search asks for eigenpairs; a test puts one here that loses a mode.
struct SearchMethods {
  /// First and second attempt.
  std::function<EigenPairs(const assembly::System&, const EigenRequest&, const ShiftedSystem&,
                           MPI_Comm)>
      lowest = lowest_pairs;
  /// Third attempt, where modes are still missing: low, high, tolerance as slice_spectrum().
  std::function<EigenPairs(const assembly::System&, double, double, double, MPI_Comm)> slice =
      slice_spectrum;
};

/// First guess (mesh.faces present) of the lowest flexible frequency [Hz]: that of a plate as thick
/// as 2 volume / area and as long as the longest side, c (2 V / A) / L^2 with c = sqrt(E / rho)
/// (the constant of a free bar or plate is near 1). In a body of several materials E is that of the
/// mean compliance, rho the mean density.
/// @param length  the body's longest side [m], where `mesh` is a part of it; 0: the mesh's own
double estimate_first_frequency(const mesh::TetMesh& mesh,
                                std::span<const elements::Elastic> regions, double length = 0);

/// Counts, solves and verifies: the lowest flexible modes up to the band's top, as many as
/// max_modes asks for above its bottom. Where modes are missing a second attempt takes a larger
/// subspace and another start, a third slices the spectrum where they must be; those that stay
/// missing are stated in the result.
/// @throws core::SolverError  see solve_modes
/// @note Collective on comm.
SearchResult search_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                          const SolveOptions& options, const assembly::System& system,
                          MPI_Comm comm, core::Trace& trace, const SearchMethods& methods = {});

/// solve_modes() with other methods inside.
modes::Modes solve_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                         const SolveOptions& options, MPI_Comm comm, core::Trace& trace,
                         const SearchMethods& methods);

}  // namespace carillon::solvers::eigen
