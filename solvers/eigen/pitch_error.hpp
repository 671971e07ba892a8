#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "solvers/eigen/search.hpp"
#include "solvers/elements/elastic.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::solvers::eigen {

/// A mode of the body, from the modes found at the solved order.
struct TrueMode {
  double found = 0;        ///< eigenvalue where its shape lay at the solved order [rad^2/s^2]
  double eigenvalue = 0;   ///< its own [rad^2/s^2]; infinite where nothing can be said
  double uncertainty = 0;  ///< [cents] by which its pitch is unknown in any case
  /// The same with half of what is added for what the next order misses, which is most of what it
  /// may miss: tells in which order modes come. 0: `eigenvalue` does.
  double likely = 0;
  double margin = 1;  ///< the error that is told over the one that the eigenvalue has
  double added = 0;   ///< [cents] that come on top in any case
};

struct TrueModes {
  std::vector<TrueMode> modes;  ///< as many as were found, in no order
  Eigen::MatrixXd fractions;    ///< of the found modes in each: found x modes
};

/// The k-th of the eigenvalues `found`, ascending, is compared with the k-th of those that should
/// be: modes that lie in the wrong order are off by as much as the frequencies in their places are,
/// and the bases of repeated modes do not matter.
/// @param truth  as many, in any order
/// @return [cents] at least 0.01 (what solver tolerances leave open)
std::vector<double> pitch_errors(std::span<const double> found, std::vector<TrueMode> truth);

/// What a mesh's order misses beyond what the next one changes, by where its elements lie.
struct ErrorMargins {
  bool is_flat = false;          ///< many elements are wider than a wall is thick
  double section_fraction = 0;   ///< of the elements, those that are all of a bar's section
  std::vector<double> at_edges;  ///< what inward edges add to each element's factor
};
/// @param mesh   a whole body
/// @param finer  the same elements at the next order
ErrorMargins error_margins(const mesh::TetMesh& mesh, const mesh::TetMesh& finer);

/// Modes of a body from what the same elements at the next order (next_order: nodes on the true
/// surface) change: a hierarchical surplus, solved nearly exactly. One step of inverse iteration on
/// that space starts from every mode, by conjugate gradients; Rayleigh and Ritz's procedure on the
/// modes and their corrections gives the pitches that the next order has; what that order itself
/// still misses is allowed for by a factor.
///
/// @param found        search of the modes of `system`, which was assembled from `mesh`
/// @param chosen       indices of pairs
/// @param eigenvalues  of the chosen pairs, ascending [rad^2/s^2]
/// @param memory       [byte] for all ranks together; what it bounds is how many modes are treated
///                     at once, whether element matrices are kept, and whether flat elements get a
///                     factor of the next order; min_estimate_bytes() at least
/// @param margins      where the mesh is a part of a body: the body's, for the part's elements;
///                     null: those of the mesh
/// @return with infinite eigenvalues where the next order's elements are turned inside out
/// @note Collective on comm; the same on every rank.
TrueModes estimate_true_modes(const mesh::TetMesh& mesh, std::span<const elements::Elastic> regions,
                              const assembly::System& system, const SearchResult& found,
                              std::span<const std::size_t> chosen,
                              std::span<const double> eigenvalues, std::int64_t memory,
                              MPI_Comm comm, const ErrorMargins* margins = nullptr);

/// Bytes that an estimate takes at least beside the pairs, all ranks together: whole fields of a
/// few modes on each, and the blocks that smooth.
std::int64_t min_estimate_bytes(const mesh::TetMesh& mesh, MPI_Comm comm);

}  // namespace carillon::solvers::eigen
