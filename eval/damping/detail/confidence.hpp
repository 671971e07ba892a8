#pragma once

#include <span>

#include "core/numbers.hpp"
#include "eval/damping/detail/estimators.hpp"

namespace carillon::eval::damping {

/// What an estimator minimises over a law's parameters, those first; where its minimum lies, and
/// what a rise of the function by one means in units of the log-likelihood.
struct Likelihood {
  Objective objective;
  Box box;
  Eigen::VectorXd best;
  double weight = 1;
};

/// The range of alpha's that stay within `drop` of the largest log-likelihood while all other
/// numbers are fitted anew (profile likelihood). Ends are infinite where no alpha is unlikely.
/// @param alpha  counted from 0; the parameter of its place in the likelihood stands for it alone
core::Range profile_interval(const ScaledLaw& law, const Likelihood& likelihood, std::size_t alpha,
                             double drop);

/// Ranges of a lower bound's alphas: from what the estimator makes of data drawn from its own
/// result (200 times, exponential excess of the same mean, always the same draws). Likelihoods do
/// not help here, as they end abruptly at the bound.
std::vector<core::Range> lower_bound_intervals(const ScaledLaw& law, const Eigen::VectorXd& target,
                                               const Eigen::VectorXd& x);

}  // namespace carillon::eval::damping
