#pragma once

#include <Eigen/Core>
#include <functional>

namespace carillon::eval::damping {

/// A function with its derivatives at one place; the value is not finite where it is not defined.
struct LocalModel {
  double value = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;  ///< or an approximation
};

using Objective = std::function<LocalModel(const Eigen::VectorXd&)>;

/// Bounds of each parameter; equal ones hold it in place, infinite ones leave it free.
struct Box {
  Eigen::VectorXd low;
  Eigen::VectorXd high;
};

struct NewtonOptions {
  /// What may be left to gain, as Newton's step foretells it, relative to 1 + |value|; that step is
  /// still taken, so that far less is left.
  double tolerance = 1e-12;
  int max_iterations = 200;
  /// Told of the start and of each step; may be empty.
  std::function<void(const Eigen::VectorXd& x, double value, double gradient)> watch;
};

struct BoundedMinimum {
  Eigen::VectorXd x;
  LocalModel at;
  double gradient = 0;  ///< largest component, bounds aside
  int iterations = 0;
  bool converged = false;
};

/// Minimum of a smooth function of few parameters within bounds: Newton's steps in the parameters
/// that no bound holds, shortened by a Levenberg-Marquardt term until the function falls as it was
/// expected to. (NLopt's methods take no Hessian, and Eigen's Levenberg-Marquardt neither bounds
/// nor what is no sum of squares.)
/// @param start  moved into the box; the objective must be finite there, or the minimum returned
///               is the start, not converged
BoundedMinimum minimise(const Objective& objective, const Eigen::VectorXd& start, const Box& box,
                        const NewtonOptions& options = {});

}  // namespace carillon::eval::damping
