#pragma once

#include <mpi.h>

#include "solvers/eigen/detail/rigid.hpp"
#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::solvers::eigen {

/// One cycle of smoothed aggregation (PETSc's GAMG) for K - shift M, with the rigid motions as
/// near-null space: symmetric positive definite.
/// @param motions  of the nodes of the mesh that `system` was made from
/// @throws core::SolverError  PETSc failed
/// @note Collective on comm.
Inverse algebraic_multigrid_cycle(const assembly::System& system, const RigidMotions& motions,
                                  double shift, MPI_Comm comm);

}  // namespace carillon::solvers::eigen
