#pragma once

#include <mpi.h>

#include <vector>

#include "solvers/eigen/detail/finer_space.hpp"
#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::solvers::eigen {

/// Fields of the solved order as fields of the next, element by element, and the transpose. Where
/// a node of the next order lies off the solved order's element (on the true surface) the field is
/// carried on along its gradient, averaged over the node's elements: a rotation stays a rotation.
/// Without that the bending of a slender round body would come with strains of its own.
class OrderTransfer {
 public:
  /// All are kept by reference.
  OrderTransfer(const mesh::TetMesh& mesh, const assembly::System& system, const FinerSpace& finer,
                MPI_Comm comm);

  /// @param owned  owned unknowns x fields
  /// @note Collective.
  Fields prolong(const Eigen::Ref<const Eigen::MatrixXd>& owned) const;
  /// This rank's elements' part of the same: the ranks' parts add up to it.
  /// @note Collective.
  void add_prolonged(const Eigen::Ref<const Eigen::MatrixXd>& owned, Fields& out) const;
  /// The transpose of prolong(): owned unknowns x fields.
  /// @note Collective.
  Eigen::MatrixXd restriction(const Fields& fine) const;

 private:
  Fields gather_owned(const Eigen::Ref<const Eigen::MatrixXd>& owned) const;

  const mesh::TetMesh& mesh_;
  const assembly::System& system_;
  const FinerSpace& finer_;
  MPI_Comm comm_;
  /// For each own element, its nodes x those of the next order; the ranks' elements together give
  /// a node's value once.
  std::vector<Eigen::MatrixXd> weights_;
};

}  // namespace carillon::solvers::eigen
