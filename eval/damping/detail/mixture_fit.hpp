#pragma once

#include <vector>

#include "eval/damping/detail/estimators.hpp"
#include "eval/damping/detail/mixture.hpp"

namespace carillon::eval::damping {

/// Standard errors are not the whole error of a feature: beats of doublets and neighbours come on
/// top, in proportion to c, by so much at least.
inline constexpr double min_proportion = 1e-3;

/// Points in units of a law's scale.
std::vector<Observed> observed_points(const DampingData& data, double scale);

/// Mean of minus the log-likelihood of a mixture, and of minus the logarithms of wide priors worth
/// about one point each, without which a handful of points leave numbers free: ln s is normal about
/// ln 0.01 (deviation 1.5), both ln means about that of the median c (deviation 4), w is
/// Beta(2, 2). By the law's parameters followed by ln s, ln t1, ln t2 and the logit of w, with
/// exact derivatives (where the law's are).
Objective mixture_objective(const ScaledLaw& law, const std::vector<Observed>& points);

/// The law's bounds, and those of the four numbers.
Box mixture_box(const ScaledLaw& law);

/// ln of the likelihood alone.
double mixture_log_likelihood(const ScaledLaw& law, const std::vector<Observed>& points,
                              const Eigen::VectorXd& x);

/// Probability of each point that it is an outlier.
Eigen::VectorXd outlier_probabilities(const ScaledLaw& law, const std::vector<Observed>& points,
                                      const Eigen::VectorXd& x);

struct MixtureEstimate {
  BoundedMinimum best;  ///< at: of mixture_objective()
  int iterations = 0;
};

/// The most likely law and mixture, by bounded Newton steps from curves between the lower bound and
/// least squares, and from least squares of relative errors, which is not led by large c. Starts
/// are tried on 500 of the points at most, evenly taken; the best three go on with all.
MixtureEstimate mixture_fit(const ScaledLaw& law, const Eigen::VectorXd& target,
                            const std::vector<Observed>& points, const Estimate& squares,
                            const Estimate& bound,
                            const std::function<Watch(int start)>& watch = {});

}  // namespace carillon::eval::damping
