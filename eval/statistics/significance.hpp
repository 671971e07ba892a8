#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace carillon::eval::statistics {

/// Whether paired values differ: Wilcoxon's signed-rank test, two-sided. Pairs of equal values are
/// left out, equal differences share their mean rank. Up to 50 pairs without equal differences or
/// equal values the probability is exact; else the normal approximation with the correction for
/// ties.
struct SignedRank {
  double positive = 0;  ///< sum of the ranks of differences a - b that are positive
  double negative = 0;
  std::size_t pairs = 0;  ///< that differ
  double p = 1;           ///< 1 where no pair differs
};
/// @throws InputError  spans of unequal length, or a value that is not finite
SignedRank signed_rank_test(std::span<const double> a, std::span<const double> b);

/// Whether means differ: Welch's t-test for unequal variances, two-sided.
struct WelchTest {
  double t = 0;        ///< of mean(a) - mean(b)
  double freedom = 0;  ///< degrees of freedom after Welch and Satterthwaite
  double p = 1;        ///< NaN for less than two values on a side, or without any variance
};
/// @throws InputError  a value that is not finite
WelchTest welch_test(std::span<const double> a, std::span<const double> b);

/// Probabilities of a family of tests, raised after Holm (1979), so that one of them falls below a
/// level by chance no more often than that level says. NaN stay and do not count.
std::vector<double> holm(std::span<const double> probabilities);

}  // namespace carillon::eval::statistics
