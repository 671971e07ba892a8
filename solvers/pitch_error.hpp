#pragma once

#include <mpi.h>

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/modes.hpp"
#include "solvers/search.hpp"

namespace carillon::solvers {

/// How far the pitch of each mode is from that of the body itself [cents], from what the same
/// elements at the next order (next_order: nodes on the true surface) change: a hierarchical
/// surplus, solved nearly exactly. One step of inverse iteration on that space starts from every
/// mode, by conjugate gradients; Rayleigh and Ritz's procedure on the modes and their corrections
/// gives the pitches that the next order has; what that order itself still misses is allowed for
/// by a factor. The k-th of the modes is compared with the k-th of those pitches: modes that lie in
/// the wrong order are off by as much as the frequencies in their places are, and the bases of
/// repeated modes do not matter.
///
/// @param found        search of the modes of `system`, which was assembled from `mesh`
/// @param chosen       indices of pairs
/// @param eigenvalues  of the chosen pairs, ascending [rad^2/s^2]
/// @param memory       [byte] for all ranks together; what it bounds is how many modes are treated
///                     at once and whether element matrices are kept. About twice the memory of K
///                     (smoothing blocks) comes on top
/// @return one for each chosen pair, at least 0.01 (what solver tolerances leave open); infinite
///         where the next order's elements are turned inside out, so that nothing can be said
/// @note Collective on comm; the same on every rank.
std::vector<double> pitch_errors(const TetMesh& mesh, std::span<const Elastic> regions,
                                 const System& system, const SearchResult& found,
                                 std::span<const std::size_t> chosen,
                                 std::span<const double> eigenvalues, std::int64_t memory,
                                 MPI_Comm comm);

}  // namespace carillon::solvers
