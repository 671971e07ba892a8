#pragma once

#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::damping {

/// @throws InputError  values that are not finite or not positive (names the point), too few points
///                     or too few different frequencies for the law and the estimator
void check_data(const DampingData& data, const DampingLaw& law, Estimator estimator);

}  // namespace carillon::eval::damping
