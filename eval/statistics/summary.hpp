#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "core/numbers.hpp"
#include "core/random.hpp"

namespace carillon::eval::statistics {

/// NaN for no values.
double mean(std::span<const double> values);

/// A number that sums a sample up.
using Statistic = std::function<double(std::span<const double>)>;

/// Interval that holds a statistic with a probability, by the percentile bootstrap (Efron 1979):
/// the statistic of so many samples that are drawn from the sample with replacement.
/// @param random  decides the draws
/// @return NaN for no values
core::Range bootstrap(std::span<const double> values, const Statistic& statistic,
                      core::RandomStream& random, double probability = 0.95, int draws = 2000);

}  // namespace carillon::eval::statistics
