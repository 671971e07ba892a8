#pragma once

#include <mpi.h>

#include "solvers/eigen_solve.hpp"
#include "solvers/rigid.hpp"

namespace carillon::solvers {

/// One cycle of smoothed aggregation (PETSc's GAMG) for K - shift M, with the rigid motions as
/// near-null space: symmetric positive definite.
/// @param motions  of the nodes of the mesh that `system` was made from
/// @throws core::SolverError  PETSc failed
/// @note Collective on comm.
Inverse algebraic_multigrid_cycle(const System& system, const RigidMotions& motions, double shift,
                                  MPI_Comm comm);

}  // namespace carillon::solvers
