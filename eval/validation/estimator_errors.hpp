#pragma once

#include <cstddef>
#include <span>

#include "core/numbers.hpp"
#include "core/random.hpp"
#include "eval/statistics/significance.hpp"
#include "eval/statistics/summary.hpp"

namespace carillon::eval::validation {

/// How far fits are from the truth: magnitudes of relative errors, |found - true| / |true|.
struct ErrorSummary {
  std::size_t fits = 0;
  std::size_t failed = 0;  ///< of these fits: they gave no number and are left out below
  double median = 0;
  core::Range median95;  ///< bootstrap
  double mean = 0;
  double lower_quartile = 0, upper_quartile = 0;
  double bias = 0;  ///< median of the errors with their signs
};
/// @param errors  relative, with their signs; NaN for a fit that failed
/// @param random  of the bootstrap
ErrorSummary summarise_errors(std::span<const double> errors, core::RandomStream& random);

/// Whether one estimator is nearer to the truth than another.
struct EstimatorComparison {
  std::size_t pairs = 0;               ///< draws in which both gave a number
  double median_difference = 0;        ///< of |error of a| - |error of b|; negative: a is nearer
  statistics::SignedRank signed_rank;  ///< of the magnitudes, pair by pair
  statistics::WelchTest welch;         ///< of their logarithms, which are nearer to normal
};
/// @param a, b  errors of fits to the same draws, as in summarise_errors
/// @throws InputError  spans of unequal length
EstimatorComparison compare_errors(std::span<const double> a, std::span<const double> b);

}  // namespace carillon::eval::validation
