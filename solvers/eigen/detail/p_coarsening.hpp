#pragma once

#include <mpi.h>

#include <memory>
#include <span>

#include "solvers/assembly/assemble.hpp"
#include "solvers/eigen/factor.hpp"

namespace carillon::solvers::eigen {

/// The equations of a body in polynomials of one degree on its elements.
struct PLevel {
  mesh::TetMesh mesh;  ///< elements of this order; positions by interpolation, no faces
  assembly::System system;
  /// Values at the nodes of the finer level from those at this level's: finer nodes x nodes, acts
  /// on the three components alike. Empty on the finest level.
  MatHandle prolongation;
};

/// A body's equations restricted to polynomials of a lower degree on the same curved elements:
/// T^T K T and T^T M T, T the values at the nodes of the higher degree. Summed element by element,
/// so that neither needs a product of large matrices.
///
/// @param mesh    the body's own elements, whose equations are restricted
/// @param finer   elements and partition of the level that the prolongation goes to: the body's
///                own, or those of a level made before
/// @param order   below that of `finer`
/// @note Collective on comm.
PLevel coarsen(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
               const mesh::TetMesh& finer, const assembly::Partition& finer_partition, int order,
               MPI_Comm comm);

}  // namespace carillon::solvers::eigen
