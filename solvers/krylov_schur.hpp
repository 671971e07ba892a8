#pragma once

#include <mpi.h>

#include "solvers/eigen_solve.hpp"

namespace carillon::solvers {

/// Start vector by mesh node, so that it is the same however the nodes are spread over ranks.
/// @param number  of the vector, in an endless row of them
/// @param out     owned unknowns
void fill_start(const System& system, std::uint64_t seed, int number,
                Eigen::Ref<Eigen::VectorXd> out);

/// The lowest pairs by SLEPc's Krylov-Schur on `shifted`: values and vectors alone.
/// @throws core::SolverError  no convergence
/// @note Collective on comm.
EigenPairs krylov_schur(const System& system, const EigenRequest& request,
                        const ShiftedSystem& shifted, MPI_Comm comm);

}  // namespace carillon::solvers
