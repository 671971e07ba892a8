#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace carillon::solvers::eigen {

/// A self-adjoint operator in the inner product of a mass matrix, block by block. Every function is
/// collective; columns hold the unknowns that this rank owns.
struct LanczosProblem {
  using Block = Eigen::Ref<Eigen::MatrixXd>;
  using ConstBlock = Eigen::Ref<const Eigen::MatrixXd>;

  Eigen::Index owned = 0;  ///< unknowns of this rank
  Eigen::Index total = 0;  ///< of all
  MPI_Comm comm = MPI_COMM_SELF;
  /// From M x: the operator times x (for shift-invert (K - sigma M)^-1 M x).
  std::function<void(const ConstBlock& mass_x, Block out)> apply;
  std::function<void(const ConstBlock& x, Block out)> mass;  ///< M x
  /// Fills start vectors: the `number`-th of an endless row of them, alike on any number of ranks.
  std::function<void(int number, Eigen::Ref<Eigen::VectorXd> out)> start;
  /// Hears after each look at the projected problem: restarts so far, how many converged, the
  /// values (descending, locked ones first) and their residuals. May be empty.
  std::function<void(int restarts, Eigen::Index converged, const Eigen::VectorXd& values,
                     const Eigen::VectorXd& residuals)>
      monitor = {};
};

struct LanczosOptions {
  int pairs = 1;  ///< how many of the largest
  /// Of ||Op x - theta x|| / theta, all in M's norm; rounding of the largest theta is no residual.
  double tolerance = 1e-12;
  /// Vectors that go through the operator together. Repeated eigenvalues come whole up to this
  /// multiplicity by construction, and beyond it by rounding as in any Krylov method.
  int block = 8;
  int basis = 0;  ///< most vectors kept at one time; 0: chosen from pairs and block
  int max_restarts = 300;
};

struct LanczosResult {
  Eigen::VectorXd values;   ///< theta, descending: all that converged before the first that did not
  Eigen::MatrixXd vectors;  ///< owned x values, M-orthonormal
  int applications = 0;     ///< of the operator, in vectors
  int restarts = 0;
};

/// Vectors that are kept where so many are asked for (LanczosOptions::basis).
/// @param asked  0: as many as suit the pairs
Eigen::Index lanczos_basis(Eigen::Index total, Eigen::Index pairs, Eigen::Index block,
                           Eigen::Index asked);

/// The largest eigenpairs of a positive operator by block Lanczos with full reorthogonalisation,
/// thick restart and locking (Grimes, Lewis and Simon 1994; Wu and Simon 2000). Products with the
/// basis are matrix products. A block that loses rank goes on with fresh vectors. The result
/// depends on the number of ranks by rounding alone.
/// @return may hold fewer than `pairs` when the restarts did not suffice
/// @note Collective on comm.
LanczosResult block_lanczos(const LanczosProblem& problem, const LanczosOptions& options);

}  // namespace carillon::solvers::eigen
