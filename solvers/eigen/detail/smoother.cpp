#include "solvers/eigen/detail/smoother.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/random.hpp"

namespace carillon::solvers::eigen {
namespace {

/// Lanczos steps for the largest eigenvalue; the estimate lies below it by a few per cent.
constexpr int lanczos_steps = 15;
constexpr double safety = 1.1;

std::vector<Eigen::Matrix3d> inverse_diagonal(const assembly::System& system, double shift) {
  const auto& graph = system.graph;
  std::vector<Eigen::Matrix3d> out;
  out.reserve(static_cast<std::size_t>(graph.rows()));
  for (std::int32_t row = 0; row < graph.rows(); ++row) {
    const auto first = graph.first[static_cast<std::size_t>(row)];
    const auto width = graph.first[static_cast<std::size_t>(row) + 1] - first;
    const auto* columns = graph.column.data() + first;
    const auto at = std::lower_bound(columns, columns + width, graph.begin + row) - columns;
    Eigen::Matrix3d block;
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index j = 0; j < 3; ++j) {
        block(i, j) =
            system.stiffness[static_cast<std::size_t>(9 * first + 3 * (i * width + at) + j)];
      }
    }
    block.diagonal().array() -= shift * system.mass[static_cast<std::size_t>(first + at)];
    out.push_back(block.inverse());
  }
  return out;
}

double dot(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, MPI_Comm comm) {
  double sum = a.cwiseProduct(b).sum();
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, comm);
  return sum;
}

}  // namespace

Smoother::Smoother(const assembly::System& system, double shift, int degree, MPI_Comm comm)
    : products_(system, comm),
      shift_(shift),
      degree_(degree),
      comm_(comm),
      inverse_blocks_(inverse_diagonal(system, shift)) {
  largest_ = safety * largest_eigenvalue(system);
}

void Smoother::multiply(const Eigen::Ref<const Eigen::MatrixXd>& x,
                        Eigen::Ref<Eigen::MatrixXd> out) const {
  products_.shifted(shift_, x, out);
}

void Smoother::divide_by_diagonal(const Eigen::Ref<const Eigen::MatrixXd>& right,
                                  Eigen::Ref<Eigen::MatrixXd> out) const {
  for (Eigen::Index k = 0; k < right.cols(); ++k) {
    for (std::size_t n = 0; n < inverse_blocks_.size(); ++n) {
      const auto row = 3 * static_cast<Eigen::Index>(n);
      out.col(k).segment<3>(row).noalias() = inverse_blocks_[n] * right.col(k).segment<3>(row);
    }
  }
}

/// From the coefficients of conjugate gradients preconditioned by the diagonal blocks (Saad 2003,
/// Iterative Methods for Sparse Linear Systems, section 6.7.3).
double Smoother::largest_eigenvalue(const assembly::System& system) const {
  const auto rows = static_cast<Eigen::Index>(3 * inverse_blocks_.size());
  Eigen::MatrixXd r(rows, 1), z(rows, 1), q(rows, 1);
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    // By mesh node: the same however the nodes are spread over ranks.
    const auto number = static_cast<std::size_t>(system.graph.begin + row);
    core::RandomStream random(0, static_cast<std::uint64_t>(system.partition.node[number]),
                              "multigrid.start");
    for (Eigen::Index c = 0; c < 3; ++c) r(3 * row + c, 0) = random.uniform(-1, 1);
  }
  divide_by_diagonal(r, z);
  Eigen::MatrixXd p = z;
  double rho = dot(r, z, comm_), last_step = 0, last_ratio = 0;
  Eigen::MatrixXd tridiagonal = Eigen::MatrixXd::Zero(lanczos_steps, lanczos_steps);
  Eigen::Index done = 0;
  for (Eigen::Index k = 0; k < lanczos_steps && rho > 0; ++k) {
    multiply(p, q);
    const double step = rho / dot(p, q, comm_);
    r -= step * q;
    divide_by_diagonal(r, z);
    const double next = dot(r, z, comm_), ratio = next / rho;
    tridiagonal(k, k) = 1 / step + (k > 0 ? last_ratio / last_step : 0);
    if (k > 0) {
      tridiagonal(k, k - 1) = tridiagonal(k - 1, k) = std::sqrt(last_ratio) / last_step;
    }
    p = z + ratio * p;
    rho = next;
    last_step = step;
    last_ratio = ratio;
    done = k + 1;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(tridiagonal.topLeftCorner(done, done),
                                                              Eigen::EigenvaluesOnly);
  return solver.eigenvalues()[done - 1];
}

void Smoother::smooth(const Eigen::Ref<const Eigen::MatrixXd>& right,
                      Eigen::Ref<Eigen::MatrixXd> solution) const {
  Eigen::MatrixXd residual = right, step(right.rows(), right.cols()),
                  scaled(right.rows(), right.cols());
  divide_by_diagonal(residual, step);
  step *= 4 / (3 * largest_);
  solution = step;
  for (int k = 2; k <= degree_; ++k) {
    multiply(step, scaled);
    residual -= scaled;
    divide_by_diagonal(residual, scaled);
    step = (2.0 * k - 3) / (2 * k + 1) * step + (8.0 * k - 4) / (2 * k + 1) / largest_ * scaled;
    solution += step;
  }
}

}  // namespace carillon::solvers::eigen
