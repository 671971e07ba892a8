#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::solvers::eigen {

struct IterativeOptions {
  double shift = 0;               ///< negative, dimensionless
  double tolerance = 1e-12;       ///< of conjugate gradients (CgOptions), rigid motions set apart
  std::int64_t factor_bytes = 0;  ///< that a factor on a coarser level may take, all ranks together
  /// Is called before each cycle; may throw, alike on every rank.
  std::function<void()> before_cycle = {};
};

/// K - shift M solved by conjugate gradients with a multigrid cycle (Multigrid), for bodies
/// whose factor does not fit. `preconditioner` is the cycle; rigid motions are solved for exactly
/// in both.
///
/// @param component  of every mesh node (node_components)
/// @return refers to `system`; its inverse throws core::SolverError, alike on every rank, when 2000
///         iterations are not enough
/// @note Collective on comm.
ShiftedSystem iterative_shifted(const mesh::TetMesh& mesh,
                                std::span<const elements::Elastic> regions,
                                const assembly::System& system,
                                const std::vector<std::int32_t>& component,
                                const IterativeOptions& options, MPI_Comm comm);

}  // namespace carillon::solvers::eigen
