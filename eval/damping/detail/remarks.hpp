#pragma once

#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::damping {

/// What a user should know of any fit: alphas held by a bound, a search that did not end, as many
/// numbers as points.
void add_remarks(DampingFit& fit);

/// What a user should know of the EMG's: whether least squares would do, points far below the
/// curve, sigma at its bound.
/// @param gaussian  least squares on the same data
void add_emg_remarks(DampingFit& fit, const DampingFit& gaussian, const DampingData& data,
                     double min_sigma);

}  // namespace carillon::eval::damping
