#pragma once

#include <mpi.h>

#include <cstdint>
#include <vector>

#include "solvers/eigen/eigen_solve.hpp"

namespace carillon::solvers::eigen {

/// Translations and rotations at a point: displacements, 3 x 6.
Eigen::Matrix<double, 3, 6> rigid_motions_at(const Vec3& arm);

/// The rigid motions of each component about its middle, evaluated at any node; entries near 1. Six
/// of each, or on a part beside mirror planes those of its class about the body's middle.
class RigidMotions {
 public:
  using AtNode = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, 6>;

  /// @param system     gives scales and class
  /// @param component  of every mesh node (node_components)
  RigidMotions(const mesh::TetMesh& mesh, const assembly::System& system,
               const std::vector<std::int32_t>& component);

  Eigen::Index count() const { return each() * static_cast<Eigen::Index>(boxes_.size()); }
  /// Of a component.
  Eigen::Index each() const { return static_cast<Eigen::Index>(kinds_.size()); }
  /// Number of the first motion that moves a node; the others of its component follow.
  Eigen::Index first_of(std::size_t node) const { return each() * component_[node]; }
  /// Displacement of a node in its component's motions: 3 x each().
  AtNode at(std::size_t node) const;

 private:
  Vec3 position(std::size_t node) const {
    return (mesh_.nodes[node] - scales_.origin) / scales_.length;
  }

  const mesh::TetMesh& mesh_;
  const assembly::Scales& scales_;
  const std::vector<std::int32_t>& component_;
  std::vector<int> kinds_;  ///< MirrorClass::rigid_motions()
  std::vector<mesh::Box> boxes_;
};

/// R^T M R of the rigid motions R: block diagonal, positive definite.
/// @note Collective on comm.
Eigen::MatrixXd gram_matrix(const assembly::System& system, const RigidMotions& motions,
                            MPI_Comm comm);

/// M-orthonormal columns that span the rigid motions: owned unknowns x motions.
/// @note Collective on comm.
Eigen::MatrixXd rigid_basis(const assembly::System& system, const RigidMotions& motions,
                            MPI_Comm comm);

/// Which eigenpairs are rigid motions and which are vibrations.
struct RigidSplit {
  std::vector<std::size_t> rigid;     ///< indices of pairs
  std::vector<std::size_t> flexible;  ///< ascending in the eigenvalue
};

/// Splits eigenpairs by their M-projection on the space of rigid motions (RigidMotions):
/// neither by their number nor by how low they are.
///
/// @param component  of every mesh node (node_components)
/// @throws core::SolverError  the pairs do not contain the whole rigid space
/// @note Collective on comm.
RigidSplit split_rigid(const mesh::TetMesh& mesh, const assembly::System& system,
                       const std::vector<std::int32_t>& component, const EigenPairs& pairs,
                       MPI_Comm comm);

}  // namespace carillon::solvers::eigen
