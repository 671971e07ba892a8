#pragma once

#include <mpi.h>

#include <Eigen/Core>

#include "solvers/eigen/detail/finer_factor.hpp"
#include "solvers/eigen/detail/finer_space.hpp"
#include "solvers/eigen/detail/local_solves.hpp"
#include "solvers/eigen/detail/order_transfer.hpp"
#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::solvers::eigen {

/// When the correction of a field is good enough.
struct CorrectionGoal {
  double fraction = 0.02;  ///< of its energy that may still be missing
  /// Missing energy that matters in no case, for each field (dimensionless, as x^T A x).
  Eigen::ArrayXd negligible;
  int max_steps = 80;
};

/// Solves A d = r on the next order's space by conjugate gradients, on many fields at once. The
/// preconditioner has two levels: the solved order's own inverse, which the search has already,
/// and overlapping blocks of the nodes of each element; where elements are flat it is the next
/// order's own factor, if that fits.
class FinerCorrection {
 public:
  /// @param mesh, system, shifted, space  are kept by reference
  /// @param memory                        [byte] for a factor, all ranks together
  FinerCorrection(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                  const assembly::System& system, const ShiftedSystem& shifted,
                  const FinerSpace& space, std::int64_t memory, MPI_Comm comm);

  /// Fields of the solved order at the nodes of the next (owned unknowns x fields).
  /// @note Collective.
  Fields prolong(const Eigen::Ref<const Eigen::MatrixXd>& owned) const;
  /// @param right  in: right-hand sides; out: what is left of them, right - A d
  /// @return d
  /// @note Collective.
  Fields solve(Fields& right, const CorrectionGoal& goal) const;

 private:
  void precondition(const Fields& residual, Fields& out) const;

  const Inverse& coarse_;
  const FinerSpace& space_;
  MPI_Comm comm_;
  OrderTransfer transfer_;
  std::optional<FinerFactor> factor_;
  std::optional<LocalSolves> local_;
};

/// Sums over unknowns of products of two sets of fields, one for each field; the same on every
/// rank to the last bit.
/// @note Collective.
Eigen::ArrayXd dots(const Fields& a, const Fields& b, MPI_Comm comm);

}  // namespace carillon::solvers::eigen
