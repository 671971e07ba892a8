#pragma once

#include <mpi.h>

#include <Eigen/Core>

#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::solvers::eigen {

struct CgOptions {
  /// Of the residual's norm under the preconditioner, sqrt(r^T B r), to that of the right side.
  double tolerance = 1e-12;
  int max_iterations = 2000;
};

/// Preconditioned conjugate gradients (Hestenes and Stiefel 1952) for many right-hand sides side by
/// side: each column has its own steps, but the matrix and the preconditioner are read once for
/// all. Columns leave as they converge.
///
/// @param product         symmetric positive definite matrix times columns
/// @param preconditioner  symmetric positive definite
/// @return iterations of the slowest column
/// @throws core::SolverError  no convergence, or the matrix or the preconditioner turns out not to
///                            be positive definite; alike on all ranks
/// @note Collective on comm.
int conjugate_gradients(const Inverse& product, const Inverse& preconditioner,
                        const CgOptions& options, const Eigen::Ref<const Eigen::MatrixXd>& right,
                        Eigen::Ref<Eigen::MatrixXd> solution, MPI_Comm comm);

}  // namespace carillon::solvers::eigen
