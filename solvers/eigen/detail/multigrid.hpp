#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "solvers/eigen/detail/p_coarsening.hpp"
#include "solvers/eigen/detail/smoother.hpp"
#include "solvers/eigen/factor.hpp"

namespace carillon::solvers::eigen {

/// Multigrid cycles for K - shift M (shift < 0) through polynomials of falling degree: Chebyshev
/// smoothing of the fourth kind (Lottes 2023, Numer. Linear Algebra Appl. 30, e2518) over the
/// blocks of each node, order 2 below orders 3 and 4, order 1 below that, and on the coarsest level
/// a direct factor where it fits, else a cycle of algebraic multigrid (PETSc's GAMG) with the rigid
/// motions as near-null space. Algebraic multigrid alone is weak on elements of high order, and
/// order 1 alone is too stiff for thin walls.
class Multigrid {
 public:
  /// @param system        is referred to
  /// @param factor_bytes  [byte] that a factor on a coarser level may take, all ranks together
  /// @throws core::SolverError  a coarse level cannot be set up
  /// @note Collective on comm, as are cycle() and prolong().
  Multigrid(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
            const assembly::System& system, double shift, std::int64_t factor_bytes, MPI_Comm comm);

  std::size_t levels() const { return coarser_.size() + 1; }
  /// Level 0 is the body's own order.
  const assembly::System& system(std::size_t level) const;
  /// Of a level below the body's own.
  const mesh::TetMesh& mesh(std::size_t level) const { return coarser_.at(level - 1)->mesh; }
  /// [byte] that a factor on the coarsest level takes, all ranks together; 0 without one.
  std::int64_t factor_bytes() const { return factor_bytes_; }

  /// One cycle from a level downward: symmetric positive definite, near (K - shift M)^-1.
  void cycle(std::size_t level, const Eigen::Ref<const Eigen::MatrixXd>& right,
             Eigen::Ref<Eigen::MatrixXd> solution) const;
  /// Fields of level + 1 on a level.
  Eigen::MatrixXd prolong(std::size_t level, const Eigen::Ref<const Eigen::MatrixXd>& coarse) const;

 private:
  Eigen::MatrixXd restriction(std::size_t level,
                              const Eigen::Ref<const Eigen::MatrixXd>& fine) const;

  const assembly::System& system_;
  MPI_Comm comm_;
  std::vector<std::unique_ptr<Smoother>> smoothers_;  ///< of all levels but the coarsest
  std::vector<std::unique_ptr<PLevel>> coarser_;
  Inverse coarsest_;
  std::int64_t factor_bytes_ = 0;
};

}  // namespace carillon::solvers::eigen
