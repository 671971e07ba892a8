#pragma once

#include <vector>

namespace carillon::eval::statistics {

/// The mean of two in the middle; NaN of none.
double median(std::vector<double> values);

}  // namespace carillon::eval::statistics
