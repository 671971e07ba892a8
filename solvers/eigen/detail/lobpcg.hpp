#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <cstdint>

#include "solvers/assembly/products.hpp"
#include "solvers/eigen/factor.hpp"

namespace carillon::solvers::eigen {

struct LobpcgProblem {
  const assembly::Products* products = nullptr;  ///< of K and M
  std::int64_t owned = 0;                        ///< unknowns of this rank
  std::int64_t total = 0;                        ///< of all
  double shift = 0;        ///< negative, dimensionless: A = K - shift M is definite
  Inverse preconditioner;  ///< symmetric positive definite, near A^-1
  /// M-orthonormal columns to stay orthogonal to, and M times them: modes that are known.
  Eigen::Ref<const Eigen::MatrixXd> known, mass_known;
  MPI_Comm comm = MPI_COMM_NULL;
};

struct LobpcgOptions {
  int pairs = 0;  ///< how many of the lowest, beside those that are known
  /// Of sqrt(r^T B r / mu), r = A x - mu M x, B the preconditioner, mu = lambda - shift: its square
  /// is about the relative error of mu. A residual below 1e-8 that rounding holds up will do too.
  double tolerance = 1e-10;
  int max_iterations = 200;  ///< without a pair that converges
};

struct LobpcgResult {
  Eigen::VectorXd values;   ///< lambda, ascending; all that were worked on
  Eigen::MatrixXd vectors;  ///< owned x values, M-orthonormal
  int converged = 0;        ///< pairs that met the tolerance, the lowest ones
  int iterations = 0;
};

/// Vectors as long as a field that the method holds at most, the problem's own aside.
std::int64_t lobpcg_vectors(std::int64_t start);

/// The lowest eigenpairs of K x = lambda M x by the locally optimal block preconditioned conjugate
/// gradient method (Knyazev 2001, SIAM J. Sci. Comput. 23, 517), in a basis that is kept
/// M-orthonormal (Hetmaniuk and Lehoucq 2006, J. Comput. Phys. 218, 324). Pairs that converged are
/// set aside, and the next start vectors take their place.
/// @param start  owned x at least `pairs` columns: the nearer to the modes the better. Those beyond
///               `pairs` are worked on too, and make the last of the wanted converge faster
/// @throws core::SolverError  the preconditioner is not positive definite
/// @note Collective on comm.
LobpcgResult lobpcg(const LobpcgProblem& problem, const LobpcgOptions& options,
                    const Eigen::Ref<const Eigen::MatrixXd>& start);

}  // namespace carillon::solvers::eigen
