#include "solvers/eigen/dense_eigen.hpp"

#include <fmt/core.h>

#include <vector>

#include "core/error.hpp"

// PETSc's header of LAPACK's functions contradicts Eigen's of BLAS', so that no file can include
// both.
extern "C" void dsyevd_(const char* job, const char* triangle, const int* n, double* a,
                        const int* leading, double* values, double* work, const int* work_size,
                        int* index_work, const int* index_work_size, int* info);

namespace carillon::solvers::eigen {
namespace {

Eigen::VectorXd solve(const char* job, Eigen::MatrixXd& matrix) {
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

Eigen::VectorXd dense_eigenpairs(Eigen::MatrixXd& matrix) {
  return solve("V", matrix);
}

Eigen::VectorXd dense_eigenvalues(Eigen::MatrixXd matrix) {
  return solve("N", matrix);
}

}  // namespace carillon::solvers::eigen
