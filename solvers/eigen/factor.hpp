#pragma once

#include <mpi.h>
#include <petscmat.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "core/handle.hpp"
#include "solvers/assembly/assemble.hpp"
#include "solvers/eigen/cholesky.hpp"
#include "solvers/libraries/environment.hpp"

namespace carillon::solvers::eigen {

using MatHandle = core::Handle<Mat, MatDestroy>;
using VecHandle = core::Handle<Vec, VecDestroy>;

/// K - shift M with entries of its own, distributed like `system`; block size 3, exact
/// preallocation.
/// @param definite  the shift is negative, so the matrix is positive definite
/// @note Collective on comm.
MatHandle shifted_matrix(const assembly::System& system, double shift, bool definite,
                         MPI_Comm comm);
/// M, with the pattern of K.
/// @note Collective on comm.
MatHandle mass_matrix(const assembly::System& system, MPI_Comm comm);

/// What all factors of one system's K - shift M share, whatever the shift.
struct FactorPlan {
  /// order[k]: number of the node eliminated k-th, by nested dissection; on rank 0 alone.
  std::vector<std::int32_t> node_order;
  std::shared_ptr<const CholeskyStructure> structure;  ///< on one rank
};
/// @throws core::SolverError  METIS failed, or out of memory
/// @note Collective on comm.
FactorPlan plan_factors(const assembly::System& system, MPI_Comm comm);

enum class FactorPurpose {
  solve,  ///< factor_shifted: Cholesky, kept; CHOLMOD on one rank, MUMPS on a group
  count,  ///< count_below: L D L^T by MUMPS, whose entries are let go as they are made
};
/// Entries and peak memory of a factor before it is made: exact structure on one rank, MUMPS'
/// estimate otherwise. Takes a small part of the factorisation's time.
/// @return the same on every rank
/// @note Collective on comm.
FactorSize predict_factor(const assembly::System& system, FactorPurpose purpose,
                          const FactorPlan& plan, MPI_Comm comm);

/// Applies (K - sigma M)^-1, or something near it that is symmetric and positive definite, to
/// columns: owned unknowns x columns. Collective.
using Inverse = std::function<void(const Eigen::Ref<const Eigen::MatrixXd>& right,
                                   Eigen::Ref<Eigen::MatrixXd> solution)>;

/// Solves with a Cholesky factor of K - shift M, shift < 0. Columns are much cheaper together than
/// one by one: the factor is read once for all of them.
/// @throws core::SolverError  not positive definite, or out of memory
/// @note Collective on comm.
Inverse factored_inverse(const assembly::System& system, double shift, const FactorPlan& plan,
                         MPI_Comm comm);

}  // namespace carillon::solvers::eigen
