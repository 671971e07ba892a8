#pragma once

#include <mpi.h>

#include <cstdint>
#include <vector>

#include "solvers/eigen_solve.hpp"

namespace carillon::solvers {

/// Which eigenpairs are rigid motions and which are vibrations.
struct RigidSplit {
  std::vector<std::size_t> rigid;     ///< indices of pairs
  std::vector<std::size_t> flexible;  ///< ascending in the eigenvalue
};

/// Splits eigenpairs by their M-projection on the space of rigid motions, six for each component:
/// neither by their number nor by how low they are.
///
/// @param component  of every mesh node (node_components)
/// @throws core::SolverError  the pairs do not contain the whole rigid space
/// @note Collective on comm.
RigidSplit split_rigid(const TetMesh& mesh, const System& system,
                       const std::vector<std::int32_t>& component, const EigenPairs& pairs,
                       MPI_Comm comm);

}  // namespace carillon::solvers
