#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <span>
#include <vector>

#include "solvers/assembly/assemble.hpp"

namespace carillon::solvers::assembly {

/// Displacements of several fields at every node: a row for each new number, x y z of each field.
using NodeFields = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// @param fields  owned unknowns x fields
/// @return all nodes x 3 fields, the same on every rank
/// @note Collective on comm.
NodeFields gather_fields(const System& system, const Eigen::Ref<const Eigen::MatrixXd>& fields,
                         MPI_Comm comm);

/// Stiffness of given constants times fields, element by element: no matrix is assembled, and
/// several materials share the elements' geometry.
/// @param mesh       the one `system` was assembled from
/// @param materials  for each product the dimensionless constants of every region
/// @param fields     owned unknowns x fields
/// @return for each of `materials` owned unknowns x fields
/// @note Collective on comm.
std::vector<Eigen::MatrixXd> apply_stiffness(
    const mesh::TetMesh& mesh, const System& system,
    std::span<const std::vector<elements::ElasticConstants>> materials,
    const Eigen::Ref<const Eigen::MatrixXd>& fields, MPI_Comm comm);

}  // namespace carillon::solvers::assembly
