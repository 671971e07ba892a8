#pragma once

#include <mpi.h>

#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::solvers::eigen {

/// The lowest pairs by SLEPc's Krylov-Schur on `shifted`: values and vectors alone.
/// @throws core::SolverError  no convergence
/// @note Collective on comm.
EigenPairs krylov_schur(const assembly::System& system, const EigenRequest& request,
                        const ShiftedSystem& shifted, MPI_Comm comm);

}  // namespace carillon::solvers::eigen
