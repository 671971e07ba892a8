#include "eval/damping/detail/linear_program.hpp"

#include <Eigen/LU>
#include <vector>

#include "core/error.hpp"

namespace carillon::eval::damping {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

}  // namespace

VectorXd linear_program(const MatrixXd& rows, const VectorXd& limits, const VectorXd& objective,
                        double box) {
  const Index m = rows.rows();
  const Index n = rows.cols();
  // The corner of the box that the objective points at, as n rows that hold x: their multipliers
  // are not negative, which every exchange keeps.
  MatrixXd held = MatrixXd::Zero(n, n);
  VectorXd held_limits = VectorXd::Constant(n, box);
  std::vector<Index> names(static_cast<std::size_t>(n));
  for (Index k = 0; k < n; ++k) {
    held(k, k) = objective[k] < 0 ? -1 : 1;
    names[static_cast<std::size_t>(k)] = m + k;
  }
  const VectorXd norms = rows.rowwise().norm();
  const Index max_exchanges = 50 * (m + n);
  for (Index exchange = 0; exchange < max_exchanges; ++exchange) {
    const Eigen::PartialPivLU<MatrixXd> factor(held);
    const VectorXd x = factor.solve(held_limits);
    const VectorXd multipliers = factor.transpose().solve(objective);
    // The row most overstepped; after many exchanges the first, which cannot go in circles.
    const bool circling = exchange > max_exchanges / 2;
    const VectorXd over = rows * x - limits;
    Index enters = -1;
    double maximum = 0;
    for (Index i = 0; i < m; ++i) {
      const double rounding = 1e-12 * (std::abs(limits[i]) + norms[i] * x.norm());
      if (over[i] <= rounding || (circling && enters >= 0)) continue;
      if (const double by = over[i] / norms[i]; by > maximum) {
        maximum = by;
        enters = i;
      }
    }
    if (enters < 0) return x;
    // rows(enters) = sum of shares times the held rows: the one whose multiplier vanishes first
    // leaves.
    const VectorXd fractions = factor.transpose().solve(rows.row(enters).transpose());
    Index leaves = -1;
    double minimum = 0;
    for (Index k = 0; k < n; ++k) {
      if (fractions[k] <= 1e-13 * fractions.cwiseAbs().maxCoeff()) continue;
      const double ratio = std::max(0.0, multipliers[k]) / fractions[k];
      const bool earlier =
          leaves >= 0 && ratio == minimum &&
          names[static_cast<std::size_t>(k)] < names[static_cast<std::size_t>(leaves)];
      if (leaves < 0 || ratio < minimum || earlier) {
        minimum = ratio;
        leaves = k;
      }
    }
    if (leaves < 0) break;
    held.row(leaves) = rows.row(enters);
    held_limits[leaves] = limits[enters];
    names[static_cast<std::size_t>(leaves)] = enters;
  }
  throw core::SolverError("the linear program has no solution");
}

}  // namespace carillon::eval::damping
