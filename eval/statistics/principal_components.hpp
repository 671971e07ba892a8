#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace carillon::eval::statistics {

/// Directions in which a sample varies most.
struct PrincipalComponents {
  std::vector<double> mean;         ///< of each column
  std::vector<double> components;   ///< count x columns, of unit length; the largest entry positive
  std::vector<double> fractions;    ///< of all variance, for each component
  std::vector<double> coordinates;  ///< rows x count
};

/// @param values  rows x columns, finite
/// @param count   components wanted; fewer where the rows do not vary in as many directions
/// @throws InputError  less than two rows, or values that do not fill whole rows
PrincipalComponents principal_components(std::span<const double> values, std::size_t columns,
                                         std::size_t count);

/// Share of the variance of numbers that their groups explain: 0 where all groups have one mean, 1
/// where each has one value. NaN of numbers that do not vary.
double explained_by_groups(std::span<const double> values, std::span<const std::size_t> groups);

}  // namespace carillon::eval::statistics
