#include "solvers/probe.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.hpp"
#include "solvers/products.hpp"

namespace carillon::solvers {
namespace {

/// As wide as products and factors work best.
constexpr Eigen::Index block = 8;
constexpr int steps = 6;

Eigen::MatrixXd random_block(const System& system, std::uint64_t seed, Eigen::Index columns) {
  Eigen::MatrixXd out(system.owned_unknowns(), columns);
  for (std::int32_t row = 0; row < system.graph.rows(); ++row) {
    const auto number = static_cast<std::size_t>(system.graph.begin + row);
    core::RandomStream random(seed, static_cast<std::uint64_t>(system.partition.node[number]),
                              "probe");
    for (Eigen::Index k = 0; k < columns; ++k) {
      for (Eigen::Index c = 0; c < 3; ++c) out(3 * row + c, k) = random.uniform(-1, 1);
    }
  }
  return out;
}

Eigen::MatrixXd gram(const Eigen::Ref<const Eigen::MatrixXd>& a,
                     const Eigen::Ref<const Eigen::MatrixXd>& b, MPI_Comm comm) {
  Eigen::MatrixXd out = a.transpose() * b;
  MPI_Allreduce(MPI_IN_PLACE, out.data(), static_cast<int>(out.size()), MPI_DOUBLE, MPI_SUM, comm);
  return out;
}

/// Takes away what lies along M-orthonormal columns, twice for the sake of rounding.
void project_out(const Eigen::Ref<const Eigen::MatrixXd>& basis,
                 const Eigen::Ref<const Eigen::MatrixXd>& mass_basis, Eigen::MatrixXd& x,
                 MPI_Comm comm) {
  for (int pass = 0; pass < 2; ++pass) x -= basis * gram(mass_basis, x, comm);
}

/// M-orthonormal columns that span those of x; directions that are lost in rounding are dropped.
void orthonormalise(const Products& products, Eigen::MatrixXd& x, Eigen::MatrixXd& mass_x,
                    MPI_Comm comm) {
  for (int pass = 0; pass < 2; ++pass) {
    mass_x.resize(x.rows(), x.cols());
    products.mass(x, mass_x);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram(x, mass_x, comm));
    const auto& values = solver.eigenvalues();
    const auto kept = (values.array() > 1e-12 * values[values.size() - 1]).count();
    const Eigen::MatrixXd map = solver.eigenvectors().rightCols(kept) *
                                values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
    x = (x * map).eval();
    mass_x = (mass_x * map).eval();
  }
}

}  // namespace

double lowest_beside(const EigenPairs& pairs, const System& system, const ShiftedSystem& shifted,
                     std::uint64_t seed, MPI_Comm comm) {
  const Products products(system, comm);
  const auto room = system.unknowns() - pairs.size();
  if (room < 1) return std::numeric_limits<double>::infinity();
  const auto width = std::min<Eigen::Index>(block, room);
  Eigen::MatrixXd x = random_block(system, seed, width), mass_x;
  project_out(pairs.vectors, pairs.mass_vectors, x, comm);
  orthonormalise(products, x, mass_x, comm);
  Eigen::MatrixXd basis = x, mass_basis = mass_x, projected;
  // Rayleigh-Ritz for (K - sigma M)^-1 in the M inner product: Q^T M (K - sigma M)^-1 M Q.
  for (int step = 0;; ++step) {
    Eigen::MatrixXd next(x.rows(), x.cols());
    shifted.inverse(mass_x, next);
    const Eigen::MatrixXd column = gram(mass_basis, next, comm);
    const auto old = projected.rows(), all = mass_basis.cols();
    Eigen::MatrixXd grown(all, all);
    grown.topLeftCorner(old, old) = projected;
    grown.rightCols(column.cols()) = column;
    grown.bottomRows(column.cols()) = column.transpose();
    projected = grown;
    if (step + 1 == steps || all + width > room) break;
    project_out(pairs.vectors, pairs.mass_vectors, next, comm);
    project_out(basis, mass_basis, next, comm);
    x = next;
    orthonormalise(products, x, mass_x, comm);
    Eigen::MatrixXd wider(basis.rows(), all + x.cols());
    wider << basis, x;
    basis = wider;
    wider << mass_basis, mass_x;
    mass_basis = wider;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(projected, Eigen::EigenvaluesOnly);
  return 1 / solver.eigenvalues()[projected.rows() - 1] + shifted.shift;
}

}  // namespace carillon::solvers
