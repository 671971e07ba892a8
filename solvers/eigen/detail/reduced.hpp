#pragma once

#include <mpi.h>

#include <Eigen/Core>

namespace carillon::solvers::eigen {

/// Sums a small matrix over the ranks: the same bits on every one, so that all decide alike.
/// @note Collective on comm.
void sum_alike(Eigen::MatrixXd& matrix, MPI_Comm comm);

/// Replaces a small matrix by that of the first rank.
/// @note Collective on comm.
void share_first(Eigen::MatrixXd& matrix, MPI_Comm comm);

/// All eigenpairs of a small symmetric matrix, found on one rank: the same bits on every one.
/// @param matrix  its lower triangle is read; the eigenvectors take its place, as columns
/// @return eigenvalues, ascending
/// @throws core::SolverError  no convergence, alike on all ranks
/// @note Collective on comm.
Eigen::VectorXd eigenpairs_alike(Eigen::MatrixXd& matrix, MPI_Comm comm);

}  // namespace carillon::solvers::eigen
