#pragma once

#include <Eigen/Core>

namespace carillon::solvers::dense {

/// All eigenpairs of a dense symmetric matrix by LAPACK's divide and conquer (dsyevd): at some
/// hundred rows many times faster than Eigen's QR iteration.
/// @param matrix  its lower triangle is read; the eigenvectors take its place, as columns
/// @return eigenvalues, ascending
/// @throws core::SolverError  no convergence
Eigen::VectorXd symmetric_eigenpairs(Eigen::MatrixXd& matrix);

/// The eigenvalues alone.
Eigen::VectorXd symmetric_eigenvalues(Eigen::MatrixXd matrix);

/// Eigenvalues and right eigenvectors of a real matrix.
struct GeneralEigenpairs {
  Eigen::VectorXcd
      values;  ///< conjugate pairs next to each other, the positive imaginary part first
  /// Unit columns; of a pair, the real part and the imaginary part of the first one's eigenvector.
  Eigen::MatrixXd vectors;
};

/// LAPACK's dgeev.
/// @throws core::SolverError  no convergence
GeneralEigenpairs general_eigenpairs(Eigen::MatrixXd matrix);

}  // namespace carillon::solvers::dense
