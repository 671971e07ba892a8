#pragma once

#include "eval/damping/detail/scaled_law.hpp"

namespace carillon::eval::damping {

/// Parameters of a law by one of the estimators.
struct Estimate {
  Eigen::VectorXd x;
  bool converged = true;
  int iterations = 0;
};

/// Told of each step of an optimiser; may be empty.
using Watch = std::function<void(const Eigen::VectorXd& x, double value, double gradient)>;

/// The curve of the least sum of squares to `target` [n, in units of the law's scale].
Estimate least_squares(const ScaledLaw& law, const Eigen::VectorXd& target,
                       const Watch& watch = {});

/// Half the sum of squares over `unit`, with its derivatives.
Objective misfit_objective(const ScaledLaw& law, const Eigen::VectorXd& target, double unit);

/// A law whose parameters have no size of their own (an expression that is not linear): in units of
/// the best of its least-squares fits, and with candidates around it.
/// @param near  makes the law in units of given alphas
ScaledLaw settled_law(const ScaledLaw& law, const Eigen::VectorXd& target,
                      const std::function<ScaledLaw(const std::vector<double>& alphas)>& near);

/// The curve below all points of `target` with the least sum of what they exceed it by: for
/// Rayleigh's law the edge of the points' lower convex hull at their mean eigenvalue. Also the most
/// likely curve if damping exceeds it exponentially and without error.
/// @param start  for a law that is not linear: where to begin, in place of the law's candidates
Estimate lower_bound(const ScaledLaw& law, const Eigen::VectorXd& target,
                     const Eigen::VectorXd* start = nullptr, const Watch& watch = {});

}  // namespace carillon::eval::damping
