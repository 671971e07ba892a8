#pragma once

#include <mpi.h>

#include <cstdint>

#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::solvers::eigen {

/// Looks for eigenpairs that a set lacks, where no inertia can be had: the lowest among the vectors
/// that are M-orthogonal to the set, from random ones, to about a thousandth (LOBPCG). A mode that
/// was lost shows as a value below the highest of the set; the further below, the surer.
///
/// @param seed  of the start vectors, which depend on nothing else but the nodes
/// @return the lowest Ritz value: above the lowest eigenvalue that the set lacks
/// @throws core::SolverError  the preconditioner is not positive definite
/// @note Collective on comm.
double lowest_beside(const EigenPairs& pairs, const assembly::System& system,
                     const ShiftedSystem& shifted, std::uint64_t seed, MPI_Comm comm);

}  // namespace carillon::solvers::eigen
