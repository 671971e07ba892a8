#pragma once

#include <initializer_list>
#include <span>

#include "eval/statistics/summary.hpp"

namespace carillon::eval::statistics {

/// Quantile of Student's t that so much probability lies within, on both sides of 0.
double students_t(double probability, double freedom);

/// Variance of an estimate, and the degrees of freedom that it is known with.
struct Variance {
  double value = 0;
  double freedom = 1;
};

/// Of an estimate whose deviation is the sum of what independent groups add to it, to first order
/// (Cochran 1977, section 6.3, with groups as units). One group alone: NaN with no freedom.
/// @param influences  of each group; their sum is 0
Variance variance_of_sum(std::span<const double> influences);

/// Student's t about an estimate with the sum of these variances, with degrees of freedom after
/// Satterthwaite (1946). No width where they are 0.
core::Range around(double estimate, std::initializer_list<Variance> parts, double probability);

}  // namespace carillon::eval::statistics
