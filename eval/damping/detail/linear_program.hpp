#pragma once

#include <Eigen/Core>

namespace carillon::eval::damping {

/// The x that makes objective . x largest while rows x <= limits, for few unknowns and many rows
/// (dual simplex: the row most overstepped enters, until none is).
/// @param rows    m x n
/// @param box     |x_k| <= box is demanded too; where it holds x back the program was unbounded
/// @return x; overstepping rows by rounding at most
/// @throws SolverError  no x satisfies all rows
Eigen::VectorXd linear_program(const Eigen::MatrixXd& rows, const Eigen::VectorXd& limits,
                               const Eigen::VectorXd& objective, double box = 1e9);

}  // namespace carillon::eval::damping
