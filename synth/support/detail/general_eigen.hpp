#pragma once

#include <Eigen/Core>

namespace carillon::synth::support {

/// Eigenvalues and right eigenvectors of a real matrix.
struct RealEigen {
  Eigen::VectorXcd
      values;  ///< conjugate pairs next to each other, the positive imaginary part first
  /// Unit columns; of a pair, the real part and the imaginary part of the first one's eigenvector.
  Eigen::MatrixXd vectors;
};

/// LAPACK's dgeev.
/// @throws SolverError  no convergence
RealEigen general_eigen(const Eigen::MatrixXd& matrix);

}  // namespace carillon::synth::support
