#include "synth/support/detail/general_eigen.hpp"

#include <fmt/core.h>

#include <vector>

#include "core/error.hpp"

// PETSc's header of LAPACK's functions contradicts Eigen's of BLAS', so that no file can include
// both.
extern "C" void dgeev_(const char* left, const char* right, const int* n, double* a,
                       const int* leading, double* real, double* imaginary, double* left_vectors,
                       const int* left_leading, double* right_vectors, const int* right_leading,
                       double* work, const int* work_size, int* info);

namespace carillon::synth::support {

RealEigen general_eigen(const Eigen::MatrixXd& matrix) {
  const auto n = static_cast<int>(matrix.rows());
  RealEigen solution{Eigen::VectorXcd(n), Eigen::MatrixXd(n, n)};
  if (n == 0) return solution;
  Eigen::MatrixXd copy = matrix;
  Eigen::VectorXd real(n), imaginary(n);
  std::vector<double> work(1);
  int work_size = -1, info = 0;
  const int one = 1;
  for (int call = 0; call < 2 && info == 0; ++call) {
    // The first call only asks how much room it takes.
    dgeev_("N", "V", &n, copy.data(), &n, real.data(), imaginary.data(), nullptr, &one,
           solution.vectors.data(), &n, work.data(), &work_size, &info);
    if (call > 0) break;
    work_size = static_cast<int>(work[0]);
    work.resize(static_cast<std::size_t>(work_size));
  }
  if (info != 0) {
    throw core::SolverError(fmt::format(
        "LAPACK found no eigenvalues of a damped body's matrix of {} rows (dgeev {})", n, info));
  }
  solution.values.real() = real;
  solution.values.imag() = imaginary;
  return solution;
}

}  // namespace carillon::synth::support
