#pragma once

#include <mpi.h>

#include <Eigen/Core>
#include <vector>

#include "solvers/assembly/products.hpp"

namespace carillon::solvers::eigen {

/// K - shift M times columns, and Chebyshev smoothing of its equations.
class Smoother {
 public:
  /// @param system  is referred to
  /// @param shift   negative
  /// @param degree  products with the matrix that one smoothing takes, and one
  /// @note Collective on comm, as are multiply and smooth.
  Smoother(const assembly::System& system, double shift, int degree, MPI_Comm comm);

  void multiply(const Eigen::Ref<const Eigen::MatrixXd>& x, Eigen::Ref<Eigen::MatrixXd> out) const;

  /// Symmetric positive definite approximation of the inverse: a Chebyshev polynomial of the fourth
  /// kind in the matrix preconditioned by its 3 x 3 diagonal blocks.
  void smooth(const Eigen::Ref<const Eigen::MatrixXd>& right,
              Eigen::Ref<Eigen::MatrixXd> solution) const;

 private:
  void divide_by_diagonal(const Eigen::Ref<const Eigen::MatrixXd>& right,
                          Eigen::Ref<Eigen::MatrixXd> out) const;
  double largest_eigenvalue(const assembly::System& system) const;

  assembly::Products products_;
  double shift_;
  int degree_;
  MPI_Comm comm_;
  std::vector<Eigen::Matrix3d> inverse_blocks_;
  double largest_ = 1;  ///< bound on the eigenvalues of D^-1 (K - shift M)
};

}  // namespace carillon::solvers::eigen
