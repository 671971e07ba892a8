#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <cstdint>

#include "solvers/eigen/detail/multigrid.hpp"

namespace carillon::solvers::eigen {

/// Vectors near the lowest modes that are not rigid: those of the coarsest level, found from random
/// ones, carried upward and improved level by level. On the body's own level they are about as far
/// off as the order below is; with one level alone they are random.
///
/// @param seed  of the random vectors, which depend on nothing else but the nodes
/// @return owned unknowns x count
/// @throws core::SolverError  a cycle is not positive definite
/// @note Collective on comm.
Eigen::MatrixXd near_modes(const Multigrid& levels, double shift, int count, std::uint64_t seed,
                           MPI_Comm comm);

}  // namespace carillon::solvers::eigen
