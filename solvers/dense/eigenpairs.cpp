#include "solvers/dense/eigenpairs.hpp"

#include <fmt/core.h>

#include <vector>

#include "core/error.hpp"

// PETSc's header of LAPACK's functions contradicts Eigen's of BLAS', so that no file can include
// both.
// NOLINTBEGIN(readability-identifier-naming): their names in LAPACK
extern "C" void dsyevd_(const char* job, const char* triangle, const int* n, double* a,
                        const int* leading, double* values, double* work, const int* work_size,
                        int* index_work, const int* index_work_size, int* info);
extern "C" void dgeev_(const char* left, const char* right, const int* n, double* a,
                       const int* leading, double* real, double* imaginary, double* left_vectors,
                       const int* left_leading, double* right_vectors, const int* right_leading,
                       double* work, const int* work_size, int* info);
// NOLINTEND(readability-identifier-naming)

namespace carillon::solvers::dense {
namespace {

Eigen::VectorXd solve_symmetric(const char* job, Eigen::MatrixXd& matrix) {
  const auto n = static_cast<int>(matrix.rows());
  Eigen::VectorXd values(n);
  if (n == 0) return values;
  std::vector<double> work(1);
  std::vector<int> index_work(1);
  int info = 0, work_size = -1, index_work_size = -1;
  for (int call = 0; call < 2 && info == 0; ++call) {
    dsyevd_(job, "L", &n, matrix.data(), &n, values.data(), work.data(), &work_size,
            index_work.data(), &index_work_size, &info);
    if (call > 0) break;
    // The first call only asked how much room it takes.
    work_size = static_cast<int>(work[0]);
    index_work_size = index_work[0];
    work.resize(static_cast<std::size_t>(work_size));
    index_work.resize(static_cast<std::size_t>(index_work_size));
  }
  if (info != 0) {
    throw core::SolverError(
        fmt::format("LAPACK found no eigenvalues of a dense matrix of {} rows (dsyevd {})", n,
                    info),
        "the mesh may have elements that are nearly flat");
  }
  return values;
}

}  // namespace

Eigen::VectorXd symmetric_eigenpairs(Eigen::MatrixXd& matrix) {
  return solve_symmetric("V", matrix);
}

Eigen::VectorXd symmetric_eigenvalues(Eigen::MatrixXd matrix) {
  return solve_symmetric("N", matrix);
}

GeneralEigenpairs general_eigenpairs(Eigen::MatrixXd matrix) {
  const auto n = static_cast<int>(matrix.rows());
  GeneralEigenpairs pairs{Eigen::VectorXcd(n), Eigen::MatrixXd(n, n)};
  if (n == 0) return pairs;
  Eigen::VectorXd real(n), imaginary(n);
  std::vector<double> work(1);
  int work_size = -1, info = 0;
  const int one = 1;
  for (int call = 0; call < 2 && info == 0; ++call) {
    // The first call only asks how much room it takes.
    dgeev_("N", "V", &n, matrix.data(), &n, real.data(), imaginary.data(), nullptr, &one,
           pairs.vectors.data(), &n, work.data(), &work_size, &info);
    if (call > 0) break;
    work_size = static_cast<int>(work[0]);
    work.resize(static_cast<std::size_t>(work_size));
  }
  if (info != 0) {
    throw core::SolverError(fmt::format(
        "LAPACK found no eigenvalues of a general matrix of {} rows (dgeev {})", n, info));
  }
  pairs.values.real() = real;
  pairs.values.imag() = imaginary;
  return pairs;
}

}  // namespace carillon::solvers::dense
