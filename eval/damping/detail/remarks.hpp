#pragma once

#include <Eigen/Core>

#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::damping {

/// Where a fitted law is negative between the lowest and the highest eigenvalue of its data:
/// nothing vibrates for ever, and no sound can be made with it.
struct NegativeBand {
  bool is = false;
  double low = 0, high = 0;  ///< frequencies [Hz]
};
NegativeBand negative_band(const synth::damping::DampingModel& model, const DampingData& data);

/// What a user should know of any fit: a law that turns negative in the data's band, alphas held by
/// a bound, a search that did not end, as many numbers as points.
void add_remarks(DampingFit& fit, const DampingData& data);

/// What a user should know of the EMG's: whether least squares would do, points far below the
/// curve, sigma at its bound.
/// @param gaussian  least squares on the same data
void add_emg_remarks(DampingFit& fit, const DampingFit& gaussian, const DampingData& data,
                     double min_sigma);

/// Which points the mixture takes for outliers, the farthest from the law by its frequency.
/// @param probabilities  of each point
void add_outlier_remark(DampingFit& fit, const DampingData& data,
                        const Eigen::VectorXd& probabilities);

}  // namespace carillon::eval::damping
