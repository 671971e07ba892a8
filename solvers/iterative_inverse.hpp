#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/eigen_solve.hpp"

namespace carillon::solvers {

/// K - shift M (shift < 0) solved by conjugate gradients with a multigrid cycle (multigrid_cycle),
/// to 1e-12 of the right side: for bodies whose factor does not fit. `preconditioner` is the cycle.
///
/// @param component     of every mesh node (node_components)
/// @param factor_bytes  [byte] that a factor on a coarser level may take, all ranks together
/// @return refers to `system`; its inverse throws core::SolverError, alike on every rank, when 2000
///         iterations are not enough
/// @note Collective on comm.
ShiftedSystem iterative_shifted(const TetMesh& mesh, std::span<const Elastic> regions,
                                const System& system, const std::vector<std::int32_t>& component,
                                double shift, std::int64_t factor_bytes, MPI_Comm comm);

}  // namespace carillon::solvers
