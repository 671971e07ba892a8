#pragma once

#include <mpi.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "solvers/eigen/detail/rigid.hpp"

namespace carillon::solvers::eigen {

/// (K - shift M)^-1 on the space of rigid motions, where K does nothing: exact but for rounding.
class RigidSolve {
 public:
  /// @param component  of every mesh node (node_components)
  /// @note Collective on comm, as is add().
  RigidSolve(const mesh::TetMesh& mesh, const assembly::System& system,
             const std::vector<std::int32_t>& component, double shift, MPI_Comm comm);

  /// Adds R (R^T (K - shift M) R)^-1 R^T `right`.
  void add(const Eigen::Ref<const Eigen::MatrixXd>& right,
           Eigen::Ref<Eigen::MatrixXd> solution) const;

 private:
  Eigen::Matrix<double, Eigen::Dynamic, 6> motions_;  ///< of each owned unknown's component
  std::vector<Eigen::Index> first_;                   ///< motion of each owned node
  Eigen::Index count_ = 0;
  Eigen::LLT<Eigen::MatrixXd> factor_;
  MPI_Comm comm_;
};

}  // namespace carillon::solvers::eigen
