#include "solvers/eigen/detail/conjugate_gradients.hpp"

#include <fmt/core.h>

#include <cmath>
#include <vector>

#include "core/error.hpp"

namespace carillon::solvers::eigen {
namespace {

/// Column by column, over all ranks.
Eigen::ArrayXd column_dots(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, MPI_Comm comm) {
  Eigen::ArrayXd out = (a.array() * b.array()).colwise().sum().transpose();
  MPI_Allreduce(MPI_IN_PLACE, out.data(), static_cast<int>(out.size()), MPI_DOUBLE, MPI_SUM, comm);
  return out;
}

/// Drops every column (or value) but some.
void keep(const std::vector<Eigen::Index>& columns, Eigen::MatrixXd& of) {
  of = of(Eigen::all, columns).eval();
}
void keep(const std::vector<Eigen::Index>& places, Eigen::ArrayXd& of) {
  of = of(places).eval();
}

}  // namespace

int conjugate_gradients(const Inverse& product, const Inverse& preconditioner,
                        const CgOptions& options, const Eigen::Ref<const Eigen::MatrixXd>& right,
                        Eigen::Ref<Eigen::MatrixXd> solution, MPI_Comm comm) {
  const auto rows = right.rows();
  solution.setZero();
  std::vector<Eigen::Index> column;  // of the caller's, for each that is still on its way
  for (Eigen::Index k = 0; k < right.cols(); ++k) column.push_back(k);
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(rows, right.cols()), r = right, z(rows, right.cols());
  preconditioner(r, z);
  Eigen::MatrixXd p = z, q(rows, right.cols());
  Eigen::ArrayXd rho = column_dots(r, z, comm);
  Eigen::ArrayXd goal = options.tolerance * options.tolerance * rho;
  for (int iteration = 0;; ++iteration) {
    if (!(rho >= 0).all()) {
      throw core::SolverError(
          "the multigrid preconditioner is not positive definite: the mesh may "
          "have elements that are nearly flat");
    }
    std::vector<Eigen::Index> open;
    for (Eigen::Index k = 0; k < x.cols(); ++k) {
      if (rho[k] > goal[k]) {
        open.push_back(k);
      } else {
        solution.col(column[static_cast<std::size_t>(k)]) = x.col(k);
      }
    }
    if (open.empty()) return iteration;
    if (iteration == options.max_iterations) {
      throw core::SolverError(fmt::format(
          "conjugate gradients came down to {:.1e} of the right side in {} iterations and not to "
          "{:.0e}: a direct solver (with a larger memory limit) or a mesh of better shaped "
          "elements is needed",
          options.tolerance * std::sqrt((rho / goal).maxCoeff()), iteration, options.tolerance));
    }
    if (static_cast<Eigen::Index>(open.size()) < x.cols()) {
      std::vector<Eigen::Index> left;
      for (const auto k : open) left.push_back(column[static_cast<std::size_t>(k)]);
      column = left;
      for (auto* matrix : {&x, &r, &p}) keep(open, *matrix);
      for (auto* values : {&rho, &goal}) keep(open, *values);
      z.resize(rows, x.cols());
      q.resize(rows, x.cols());
    }
    product(p, q);
    const Eigen::ArrayXd curvature = column_dots(p, q, comm);
    if (!(curvature > 0).all()) {
      throw core::SolverError(
          "K - sigma M is not positive definite: the mesh may have elements "
          "that are nearly flat");
    }
    const Eigen::ArrayXd step = rho / curvature;
    x += p * step.matrix().asDiagonal();
    r -= q * step.matrix().asDiagonal();
    preconditioner(r, z);
    const Eigen::ArrayXd next = column_dots(r, z, comm);
    p = z + p * (next / rho).matrix().asDiagonal();
    rho = next;
  }
}

}  // namespace carillon::solvers::eigen
