#pragma once

#include <Eigen/Core>
#include <vector>

namespace carillon::solvers::elements {

/// Points and weights on the reference tetrahedron; all weights positive, they sum to 1/6 (its
/// volume).
struct TetrahedronRule {
  std::vector<Eigen::Vector4d> barycentric;
  std::vector<double> weights;
  std::size_t size() const { return weights.size(); }
};

/// Conical product of Gauss-Jacobi rules with `points` in each direction (Stroud 1971): exact for
/// polynomials of total degree 2 points - 1. The rule is made once and kept.
/// @param points  1 to 16
const TetrahedronRule& tetrahedron_rule(int points);

/// The same on the reference triangle; weights sum to 1/2 (its area).
struct TriangleRule {
  std::vector<Eigen::Vector3d> barycentric;
  std::vector<double> weights;
  std::size_t size() const { return weights.size(); }
};
const TriangleRule& triangle_rule(int points);

/// Gauss-Jacobi points in (0, 1) and weights for the weight function (1 - x)^power, by the
/// eigenvalues of Jacobi's matrix (Golub and Welsch 1969); weights sum to 1 / (power + 1).
void gauss_jacobi(int points, int power, Eigen::VectorXd& x, Eigen::VectorXd& weights);

}  // namespace carillon::solvers::elements
