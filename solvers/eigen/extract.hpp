#pragma once

#include <mpi.h>

#include <span>
#include <vector>

#include "solvers/eigen/eigen_solve.hpp"
#include "solvers/elements/elastic.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::solvers::eigen {

/// Nodes of the boundary faces, in the order of their mesh numbers, and the faces by them.
/// @param nodes  mesh node of each surface node
modes::ModeSurface surface_of(const mesh::TetMesh& mesh, std::vector<std::int32_t>& nodes);

/// -1 where the largest entry of a shape is negative (the first of those that are equal to 1e-6),
/// else 1.
double leading_sign(const Eigen::Ref<const Eigen::VectorXd>& shape);

/// What is kept of chosen eigenpairs, in SI units.
struct ModeFields {
  /// Rayleigh quotients of element energies: strain energy is summed from strains, not from
  /// x^T K x, so that it keeps its digits on thin bodies.
  std::vector<double> eigenvalues;                    ///< [rad^2/s^2]
  Eigen::MatrixXd kinetic_fraction, strain_fraction;  ///< modes x regions
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> shapes;
};

/// The sign of a shape is such that its largest entry is positive (the first of those that are
/// equal to 1e-6).
/// @param chosen         indices of pairs
/// @param surface_nodes  mesh nodes whose displacements are kept
/// @return the same on every rank
/// @note Collective on comm.
ModeFields extract_fields(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                          const assembly::System& system, const EigenPairs& pairs,
                          std::span<const std::size_t> chosen,
                          std::span<const std::int32_t> surface_nodes, MPI_Comm comm);

}  // namespace carillon::solvers::eigen
