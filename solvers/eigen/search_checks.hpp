#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "solvers/eigen/search.hpp"

namespace carillon::solvers::eigen {

/// Value of the k-th flexible mode that was found.
double flexible_value(const SearchResult& found, std::size_t k);

/// A value between flexible modes k - 1 and k, where there is room for a shift (relative gap above
/// 1e-6).
std::optional<double> gap_below(const SearchResult& found, std::size_t k);

/// Largest residual of the first `wanted` flexible modes.
double worst_residual(const SearchResult& found, std::int64_t wanted);

/// @throws core::SolverError  one of the first `wanted` flexible modes has a residual above 1e-6,
///                            and above 1e-2 in the energy norm
void refuse_bad_residuals(const SearchResult& found, std::int64_t wanted,
                          const assembly::Scales& scales);

/// Parts that share a point or an edge alone swing about it without strain: more zero modes than
/// rigid ones, in any mixture.
/// @param estimate  of the lowest flexible eigenvalue
/// @throws core::SolverError  there are such motions
void refuse_mechanism(const EigenPairs& pairs, std::int64_t rigid, double estimate);

/// Number of eigenvalues below a value, rigid modes included.
using Count = std::function<std::int64_t(double value)>;

/// Two values between which fewer modes were found than inertia counts.
struct Lack {
  double low = 0, high = 0;
};

/// Where modes are missing, by bisection over the gaps between those that were found.
/// @param rigid  rigid modes, which lie below every cut
/// @param top    a value above which nothing is looked for, in a gap or above all modes
/// @return disjoint intervals, ascending, whose ends lie in gaps; empty when the lowest of them
///         cannot be fenced in from below
std::vector<Lack> find_lacks(const SearchResult& found, std::int64_t rigid, double top,
                             const Count& count);

/// The pairs with those of the slices in place of what was found inside the lacks, ascending;
/// values and vectors alone.
EigenPairs with_slices(const SearchResult& found, std::span<const Lack> lacks,
                       std::span<const EigenPairs> slices);

/// The highest gap below which nothing is missing, by bisection: 0 where there is none.
double verified_prefix(const SearchResult& found, std::int64_t rigid, const Count& count);

}  // namespace carillon::solvers::eigen
