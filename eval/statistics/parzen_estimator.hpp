#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/random.hpp"

namespace carillon::eval::statistics {

/// One coordinate of what is searched.
struct ParzenAxis {
  std::size_t choices = 0;  ///< so many values without an order; 0: any number between 0 and 1
};

/// Of each axis the number, or the choice's, counted from 0.
using ParzenPoint = std::vector<double>;

/// Trials that are drawn anywhere before the estimator has something to go by.
inline constexpr std::size_t parzen_drawn_first = 8;

/// The next point to try by a Parzen estimator (Bergstra, Bardenet, Bengio and Kegl, Algorithms for
/// hyper-parameter optimization, NIPS 2011, section 4): densities l of the best 15 % of the points
/// and g of the others, axis by axis; of 24 draws from l the one with the highest l / g. Densities
/// of numbers are normal kernels cut off at 0 and 1, as wide as the further of the neighbours is
/// away, and one wide kernel of the prior; of choices their counts and one more of each.
/// @param best_first  what was tried, the best first
/// @return a point that was not tried; nothing where there is none
std::optional<ParzenPoint> next_parzen_point(std::span<const ParzenAxis> axes,
                                             std::span<const ParzenPoint> best_first,
                                             core::RandomStream& random);

}  // namespace carillon::eval::statistics
