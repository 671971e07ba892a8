#pragma once

#include <petscmat.h>

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "core/handle.hpp"
#include "solvers/assemble.hpp"
#include "solvers/environment.hpp"

namespace carillon::solvers {

using MatHandle = core::Handle<Mat, MatDestroy>;
using VecHandle = core::Handle<Vec, VecDestroy>;

/// K - shift M, distributed like `system`; block size 3, exact preallocation.
/// @param definite  the shift is negative, so the matrix is positive definite
/// @note Collective on comm.
MatHandle shifted_matrix(const System& system, double shift, bool definite, MPI_Comm comm);
/// M, as one matrix of node pairs that acts on the three components alike.
/// @note Collective on comm.
MatHandle mass_matrix(const System& system, MPI_Comm comm);

enum class FactorMethod {
  cholmod,           ///< supernodal Cholesky on one rank
  mumps_definite,    ///< multifrontal Cholesky
  mumps_indefinite,  ///< multifrontal L D L^T with pivoting, knows its inertia
};

/// Signs of the pivots; Sylvester: those of the eigenvalues.
struct Inertia {
  std::int64_t negative = 0;
  std::int64_t zero = 0;
  std::int64_t positive = 0;
};

/// A direct factorisation, ready to solve with. Workspace that turns out too small is doubled, at
/// most three times.
class Factorization {
 public:
  /// @param node_order  elimination order of the nodes for cholmod (nested_dissection); empty: its
  ///                    own. MUMPS always orders by itself (PORD)
  /// @throws core::SolverError  singular, not positive definite, or out of memory
  /// @note Collective on the matrix's communicator.
  Factorization(Mat matrix, FactorMethod method, std::span<const std::int32_t> node_order);

  /// Any number of right-hand sides, owned unknowns x columns: much cheaper by the column than one
  /// alone, as the factor is read once for all of them.
  /// @note Collective.
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& right,
             Eigen::Ref<Eigen::MatrixXd> solution) const;
  /// Of mumps_indefinite alone.
  Inertia inertia() const;

 private:
  bool attempt(Mat matrix, FactorMethod method, int workspace_percent,
               std::span<const std::int32_t> node_order);

  MatHandle factor_;
};

}  // namespace carillon::solvers
