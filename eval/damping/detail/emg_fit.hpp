#pragma once

#include "eval/damping/detail/estimators.hpp"

namespace carillon::eval::damping {

/// Beyond this Gaussian width in units of the exponential's the excess cannot be told from none:
/// the skewness that it leaves is 2e-9.
constexpr double largest_kappa = 1e3;

/// Mean of minus the log-likelihood of `target` [n, in units of the law's scale], by the law's
/// parameters followed by ln sigma and ln kappa, with exact derivatives (where the law's are).
/// @param relative  sigma and kappa are those of a mode with c of one unit, and grow with the law's
///                  value
Objective emg_objective(const ScaledLaw& law, const Eigen::VectorXd& target, bool relative);

/// The law's bounds, and those of ln sigma and ln kappa.
Box emg_box(const ScaledLaw& law, double min_sigma);

/// The most likely law, sigma and kappa, by bounded Newton steps from eight starts: the lower bound
/// with three widths, least squares of all points and of points lowered by the excess that their
/// moments show, and three curves between.
struct EmgEstimate {
  BoundedMinimum best;  ///< at: of emg_objective()
  int iterations = 0;
};
EmgEstimate emg_fit(const ScaledLaw& law, const Eigen::VectorXd& target, double min_sigma,
                    bool relative, const Estimate& squares, const Estimate& bound,
                    const std::function<Watch(int start)>& watch = {});

}  // namespace carillon::eval::damping
