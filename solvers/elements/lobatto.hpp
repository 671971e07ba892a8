#pragma once

#include <Eigen/Core>

namespace carillon::solvers::elements {

/// The order + 1 Gauss-Lobatto points of [0, 1], ascending, both ends among them: where Lagrange
/// polynomials of a high order stay well behaved.
/// @param order  1 to 24
const Eigen::VectorXd& lobatto_nodes(int order);

/// Lagrange polynomials through these points, and their derivatives, at x.
struct LineShapes {
  Eigen::VectorXd values;  ///< order + 1
  Eigen::VectorXd slopes;  ///< order + 1
};
LineShapes line_shapes(int order, double x);

}  // namespace carillon::solvers::elements
