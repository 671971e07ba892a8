#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace carillon::eval::perception {

/// Row or column that has no partner.
inline constexpr std::size_t unpaired = static_cast<std::size_t>(-1);

/// Pairs each row with one column at most, and each column with one row, so that the sum of gains
/// is greatest (the Hungarian method by shortest augmenting paths, Jonker and Volgenant 1987).
/// @param gains  rows x columns, not negative; a pair that gains nothing is not made
/// @return the column of each row, or `unpaired`
/// @throws InputError  values that do not fill the rows, or a gain that is negative or not finite
std::vector<std::size_t> best_pairs(std::span<const double> gains, std::size_t rows,
                                    std::size_t columns);

}  // namespace carillon::eval::perception
