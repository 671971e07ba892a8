#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "solvers/assembly/assemble.hpp"
#include "solvers/eigen/factor.hpp"
#include "solvers/eigen/transformation.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::solvers::eigen {

/// Residuals above this are judged in the energy norm too.
inline constexpr double target_residual = 1e-8;

/// Vectors that LOBPCG works on beside those wanted: the last of the wanted converge as fast as
/// these are far above.
constexpr int guard_vectors = 4;

/// Number of eigenvalues of K x = lambda M x below `value` (dimensionless): the negative pivots of
/// K - value M, by Sylvester's law of inertia. A value that hits an eigenvalue is moved up by 1e-6
/// of itself.
/// @throws core::SolverError  the matrix cannot be factored
/// @note Collective on comm.
std::int64_t count_below(const assembly::System& system, double value, const FactorPlan& plan,
                         MPI_Comm comm);

/// Eigenpairs of K x = lambda M x, ascending, dimensionless.
struct EigenPairs {
  std::vector<double> values;
  Eigen::MatrixXd vectors;        ///< owned unknowns x pairs, M-normalised
  Eigen::MatrixXd mass_vectors;   ///< M times them
  std::vector<double> residuals;  ///< ||r|| / (|lambda| ||M x||), r = K x - lambda M x
  /// sqrt(r^T A^-1 r / (lambda - sigma)), A = K - sigma M: the residual in the norm that bounds the
  /// relative error of lambda by its square (Kato-Temple). Only where `residuals` is above 1e-8,
  /// else 0: on very thin bodies rounding x to double precision alone gives a residual of
  /// 1e-16 (largest eigenvalue / lambda), in directions that carry no energy. By the preconditioner
  /// in place of A^-1: an estimate where that is a multigrid cycle.
  std::vector<double> energy_residuals;
  double orthonormality = 0;                                      ///< max |X^T M X - I|
  modes::EigenSolver solver = modes::EigenSolver::block_lanczos;  ///< that found them

  Eigen::Index size() const { return vectors.cols(); }
};

/// K - sigma M of a negative shift sigma, ready to solve with. Refers to the System it was made
/// from, which must live as long.
struct ShiftedSystem {
  double shift = 0;               ///< sigma, dimensionless
  Transformation transformation;  ///< K, M and the solves as SLEPc knows them
  Inverse inverse;  ///< (K - sigma M)^-1; exact to rounding, or to the tolerance of a CG solve
  /// The same or a cheap stand-in for it, symmetric and positive definite: the factor itself, or
  /// one multigrid cycle.
  Inverse preconditioner;
  /// Where `inverse` is iterative, the other way to the lowest modes: vectors near them (count,
  /// seed: owned unknowns x count), and M-orthonormal rigid motions to set apart. Else empty.
  std::function<Eigen::MatrixXd(int, std::uint64_t)> near_modes;
  Eigen::MatrixXd rigid;
  std::int64_t coarse_factor = 0;  ///< [byte] that a factor on a coarser level takes, all ranks
};

/// Cholesky of K - sigma M by CHOLMOD on one rank, by MUMPS on a group (METIS order).
/// @param before_solve  is called before each solve with the factor; may throw, alike on all ranks
/// @throws core::SolverError  not positive definite, or out of memory
/// @note Collective on comm.
ShiftedSystem factor_shifted(const assembly::System& system, double shift, const FactorPlan& plan,
                             MPI_Comm comm, std::function<void()> before_solve = {});

struct EigenRequest {
  int pairs = 0;             ///< how many of the lowest
  double tolerance = 1e-12;  ///< of the transformed problem; LOBPCG: LobpcgOptions
  std::uint64_t seed = 0;    ///< of the start vectors, which depend on nothing else but the nodes
  modes::EigenSolver solver = modes::EigenSolver::block_lanczos;
  int basis = 0;  ///< most vectors held at a time by block_lanczos; 0: chosen from `pairs`
  /// Owned unknowns x any: the lowest flexible modes as far as they are known. LOBPCG goes on from
  /// them.
  Eigen::MatrixXd start = {};
};

/// The lowest eigenpairs by shift-invert about a negative shift, where K - sigma M is positive
/// definite; with its preconditioner alone (LOBPCG) where the inverse is iterative and Krylov-Schur
/// is not asked for. Problems of a few hundred unknowns, and those that ask for a good part of all
/// modes, are solved densely.
/// @return at least `pairs` of them unless the problem has fewer
/// @throws core::SolverError  no convergence
/// @note Collective on comm.
EigenPairs lowest_pairs(const assembly::System& system, const EigenRequest& request,
                        const ShiftedSystem& shifted, MPI_Comm comm);

/// Fills what is known of eigenpairs from their values and vectors: mass_vectors, residuals,
/// energy_residuals and orthonormality.
/// @note Collective on comm.
void measure(const assembly::System& system, const ShiftedSystem& shifted, MPI_Comm comm,
             EigenPairs& pairs);

}  // namespace carillon::solvers::eigen
