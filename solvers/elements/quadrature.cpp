#include "solvers/elements/quadrature.hpp"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <cstddef>

namespace carillon::solvers::elements {
namespace {

TetrahedronRule make_tetrahedron_rule(int points) {
  std::array<Eigen::VectorXd, 3> x, w;
  for (int power = 0; power < 3; ++power) {
    const auto p = static_cast<std::size_t>(power);
    gauss_jacobi(points, power, x[p], w[p]);
  }
  TetrahedronRule rule;
  // Duffy: (u, v, t) in the cube -> L1 = u, L2 = v (1-u), L3 = t (1-u)(1-v); the Jacobian
  // (1-u)^2 (1-v) is the weight function of the one-dimensional rules.
  for (int i = 0; i < points; ++i) {
    for (int j = 0; j < points; ++j) {
      for (int k = 0; k < points; ++k) {
        const double u = x[2][i], v = x[1][j], t = x[0][k];
        const double l1 = u, l2 = v * (1 - u), l3 = t * (1 - u) * (1 - v);
        rule.barycentric.emplace_back((1 - u) * (1 - v) * (1 - t), l1, l2, l3);
        rule.weights.push_back(w[2][i] * w[1][j] * w[0][k]);
      }
    }
  }
  return rule;
}

TriangleRule make_triangle_rule(int points) {
  Eigen::VectorXd u, u_weights, v, v_weights;
  gauss_jacobi(points, 1, u, u_weights);
  gauss_jacobi(points, 0, v, v_weights);
  TriangleRule rule;
  for (int i = 0; i < points; ++i) {
    for (int j = 0; j < points; ++j) {
      const double second = v[j] * (1 - u[i]);
      rule.barycentric.emplace_back(1 - u[i] - second, u[i], second);
      rule.weights.push_back(u_weights[i] * v_weights[j]);
    }
  }
  return rule;
}

constexpr int max_points = 16;

/// Rules of 1 to max_points points in each direction.
template <class Rule>
std::array<Rule, max_points> all_rules(Rule (*make)(int)) {
  std::array<Rule, max_points> all;
  for (int n = 1; n <= max_points; ++n) all[static_cast<std::size_t>(n - 1)] = make(n);
  return all;
}

}  // namespace

void gauss_jacobi(int points, int power, Eigen::VectorXd& x, Eigen::VectorXd& weights) {
  // Monic Jacobi polynomials on (-1, 1) with weight (1 - s)^a (a = power), recurrence
  // coefficients for alpha = a, beta = 0 (Gautschi 2004, table 1.1).
  const double a = power;
  Eigen::VectorXd diagonal(points), off(points > 1 ? points - 1 : 0);
  for (int n = 0; n < points; ++n) {
    const double d = (2 * n + a) * (2 * n + a + 2);
    diagonal[n] = power == 0 ? 0 : -a * a / d;
    if (n == 0 && power > 0) diagonal[0] = -a / (a + 2);
  }
  for (int n = 1; n < points; ++n) {
    const double s = 2 * n + a;
    off[n - 1] = std::sqrt(4.0 * n * n * (n + a) * (n + a) / (s * s * (s + 1) * (s - 1)));
  }
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, off);
  x = (solver.eigenvalues().array() + 1) / 2;
  weights = solver.eigenvectors().row(0).array().square().transpose() / (power + 1);
}

const TetrahedronRule& tetrahedron_rule(int points) {
  static const auto rules = all_rules(make_tetrahedron_rule);
  return rules.at(static_cast<std::size_t>(points - 1));
}

const TriangleRule& triangle_rule(int points) {
  static const auto rules = all_rules(make_triangle_rule);
  return rules.at(static_cast<std::size_t>(points - 1));
}

}  // namespace carillon::solvers::elements
