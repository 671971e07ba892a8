#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/trace.hpp"
#include "solvers/eigen/pitch_error.hpp"
#include "solvers/eigen/search.hpp"

namespace carillon::solvers::basis {

/// Modes at one Poisson's ratio, as a basis sees them. Dimensionless.
struct Snapshot {
  double poisson_ratio = 0;
  Eigen::VectorXd eigenvalues;  ///< flexible ones, ascending
  double complete_below = 0;    ///< none is missing below
  Eigen::MatrixXd coordinates;  ///< V^T M X: basis x eigenvalues
  /// Of the lowest modes, those that requests reach; empty where no error was asked for.
  eigen::TrueModes truth;
};

/// Span of a body's modes at a few Poisson's ratios (snapshots), in which any other ratio is a
/// dense problem: K(nu) = a(nu) K_lambda + b(nu) K_mu with Young's modulus and density fixed.
struct PoissonBasis {
  std::vector<elements::Elastic>
      regions;  ///< their moduli and densities; Poisson's ratio is not used
  std::shared_ptr<const assembly::System>
      system;                       ///< of `reference`: scales and partition serve all
  std::vector<Snapshot> snapshots;  ///< by ascending ratio
  double reference = 0;             ///< Poisson's ratio of `shifted`
  eigen::ShiftedSystem shifted;     ///< K - sigma M, whose inverse measures residuals
  int components = 0;
  bool counted = true;  ///< inertia vouches for every snapshot
  modes::EigenSolver eigen_solver =
      modes::EigenSolver::block_lanczos;  ///< of the snapshots, as the next
  modes::LinearSolver linear_solver = modes::LinearSolver::direct;
  Eigen::MatrixXd vectors;  ///< V: owned unknowns x basis, M-orthonormal, no rigid motions
  Eigen::MatrixXd lambda_part, mu_part;  ///< V^T K V for lambda = 1, mu = 0 and the other way round
                                         ///< (times each region's modulus in the largest)

  Eigen::Index size() const { return vectors.cols(); }
};

/// Solves a body at some Poisson's ratios and joins the modes to a basis; directions that add
/// nothing are dropped.
/// @param regions  moduli and densities; every region has the same Poisson's ratio
/// @param ratios   of the snapshots, ascending; the middle one becomes the reference
/// @param options  band of the snapshots, `beyond` times as wide as those it serves
/// @param mirror   the class of fields, where the mesh is a part beside mirror planes
/// @param margins  for estimate_true_modes()
/// @param trace    stages of a solve, and "basis", are added
/// @return nothing where the vectors would take more than half of options.memory_limit, or where
///         the reference has no mode in the band though others have
/// @throws as solve_modes
/// @note Collective on comm.
std::optional<PoissonBasis> make_poisson_basis(const mesh::TetMesh& mesh,
                                               std::span<const elements::Elastic> regions,
                                               std::span<const double> ratios,
                                               const eigen::SolveOptions& options,
                                               const assembly::MirrorClass& mirror,
                                               const eigen::ErrorMargins* margins, MPI_Comm comm,
                                               core::Trace& trace);

/// How far snapshots are to reach beyond the bands that a basis serves, in frequency and in number
/// of modes: modes at another Poisson's ratio lie elsewhere, and the bounds want room.
constexpr double beyond = 1.3;

/// Modes of another Poisson's ratio within a basis.
struct RitzModes {
  /// Pairs, all of them flexible. Counted as far as the bounds hold.
  eigen::SearchResult found;
  /// Lower bounds of the pairs' eigenvalues; the values themselves are upper ones.
  std::vector<double> lower;
  Eigen::MatrixXd coordinates;  ///< basis x pairs
  /// Of each pair, from the snapshots' true modes that it overlaps, in units of the pairs' values;
  /// empty without them.
  std::vector<eigen::TrueMode> truth;
};

/// Which modes are wanted. Eigenvalues are dimensionless.
struct RitzRequest {
  double bottom = 0;  ///< modes are counted from here
  double top = 0;     ///< none is wanted above
  int max_modes = 0;  ///< so many above `bottom` at most
};

/// Ritz pairs with certified bounds: no further factorisation, one dense eigenproblem, and a
/// solution of (K - sigma M) z = r for each pair.
/// @return the pairs that are wanted and a few above them
/// @note Collective on comm.
RitzModes ritz_modes(const mesh::TetMesh& mesh, const PoissonBasis& basis, double poisson_ratio,
                     const RitzRequest& request, MPI_Comm comm);

}  // namespace carillon::solvers::basis
