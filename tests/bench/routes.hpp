#pragma once

#include <string>
#include <vector>

#include "solvers/assembly/assemble.hpp"
#include "stages.hpp"

namespace carillon::bench {

/// The lowest pairs of K x = lambda M x by one route.
struct Answer {
  std::vector<Stage> stages;   ///< "factor" and "iterate", and what else belongs to the route
  std::vector<double> values;  ///< dimensionless, ascending
  std::string refused;         ///< why nothing was computed; empty when it was
};

/// Carillon's: METIS order, CHOLMOD, block Lanczos; then the count by inertia above the last pair.
/// @throws core::Error  the count is not the number of pairs
Answer carillon_route(const solvers::assembly::System& system, double shift, int pairs);

/// Stock SLEPc: Krylov-Schur with shift-and-invert, MUMPS for Cholesky, all by default.
Answer slepc_route(const solvers::assembly::System& system, double shift, int pairs);

/// Eigen's SimplicialLDLT with Spectra's shift-and-invert solver, both by default.
/// @param max_flops  of the factorisation; beyond, the route is refused
Answer spectra_route(const solvers::assembly::System& system, double shift, int pairs,
                     double max_flops);

}  // namespace carillon::bench
