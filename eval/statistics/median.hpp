#pragma once

#include <vector>

namespace carillon::eval {

/// The upper one of two in the middle; `values` must not be empty.
double median(std::vector<double> values);

}  // namespace carillon::eval
