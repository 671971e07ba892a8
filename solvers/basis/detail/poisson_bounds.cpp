#include "solvers/basis/detail/poisson_bounds.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "solvers/dense/eigenpairs.hpp"

namespace carillon::solvers::basis {

double stiffness_ratio(double from, double to) {
  return std::min((1 + from) / (1 + to), (1 - 2 * from) / (1 - 2 * to));
}

std::vector<double> stiffness_weights(std::span<const double> ratios, double to) {
  std::vector<double> weights(ratios.size(), 0.0);
  const auto above =
      static_cast<std::size_t>(std::upper_bound(ratios.begin(), ratios.end(), to) - ratios.begin());
  if (above == 0 || above == ratios.size()) {
    const auto nearest = above == 0 ? 0 : above - 1;
    weights[nearest] = stiffness_ratio(ratios[nearest], to);
    return weights;
  }
  // Shear and volume parts agree.
  const double low = ratios[above - 1], high = ratios[above];
  Eigen::Matrix2d parts;
  parts << 1 / (1 + low), 1 / (1 + high), 1 / (1 - 2 * low), 1 / (1 - 2 * high);
  const Eigen::Vector2d pair = parts.inverse() * Eigen::Vector2d(1 / (1 + to), 1 / (1 - 2 * to));
  weights[above - 1] = std::max(0.0, pair[0]);
  weights[above] = std::max(0.0, pair[1]);
  return weights;
}

double complement_bound(std::span<const KnownSpectrum> known, const Eigen::MatrixXd& trials) {
  double top = 0;
  Eigen::Index columns = 0;
  for (const auto& part : known) {
    top += part.weight * part.complete_below;
    columns += part.eigenvalues.size();
  }
  if (columns == 0) return top;
  // The minorant is `top` less W W^T: eigenvectors weighted by how far below they lie.
  Eigen::MatrixXd weighted(trials.rows(), columns);
  Eigen::Index next = 0;
  for (const auto& part : known) {
    const auto count = part.eigenvalues.size();
    const Eigen::VectorXd depth = (part.complete_below - part.eigenvalues.array()).max(0);
    weighted.middleCols(next, count) =
        part.vectors * (part.weight * depth).cwiseSqrt().asDiagonal();
    next += count;
  }
  weighted -= trials * (trials.transpose() * weighted).eval();
  const auto taken = dense::symmetric_eigenvalues(weighted.transpose() * weighted);
  return top - std::max(0.0, taken.maxCoeff());
}

RitzBounds bound_ritz_values(const Eigen::VectorXd& ritz_values, const Eigen::MatrixXd& gram,
                             double ceiling, double tightness) {
  const auto count = ritz_values.size();
  RitzBounds bounds;
  bounds.lower = Eigen::VectorXd::Zero(count);
  if (!(ceiling > 0)) return bounds;
  // Each level s bounds the Ritz values up to it; 1 / (1 - s / ceiling) doubles from one to the
  // next. Nearer to the ceiling than the last the bounds are of no use.
  constexpr int levels = 6;
  Eigen::Index next = 0;
  double s = 0;
  for (int level = 1; level <= levels; ++level) {
    const double stretch = std::ldexp(1.0, level);
    s = ceiling * (1 - 1 / stretch);
    const auto values =
        dense::symmetric_eigenvalues(ritz_values.asDiagonal().toDenseMatrix() - stretch * gram);
    // Above the last level an eigenvalue is at least that level.
    for (; next < count && (ritz_values[next] <= s || level == levels); ++next) {
      bounds.lower[next] = std::min(s, values[next]);
    }
  }
  bounds.counted_below = s;
  for (Eigen::Index k = 0; k < count; ++k) {
    if (ritz_values[k] - bounds.lower[k] <= tightness * ritz_values[k]) continue;
    bounds.counted_below = std::min(bounds.counted_below, bounds.lower[k]);
    break;
  }
  return bounds;
}

}  // namespace carillon::solvers::basis
