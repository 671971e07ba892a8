#include "solvers/elements/lobatto.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace carillon::solvers::elements {
namespace {

constexpr int highest_order = 24;

/// Roots of (1 - s^2) P'_n(s) by Newton's method from Chebyshev's points, on [0, 1].
Eigen::VectorXd make_nodes(int n) {
  Eigen::VectorXd x(n + 1);
  for (int i = 0; i <= n; ++i) {
    double s = -std::cos(std::numbers::pi * i / n);
    for (int step = 0; step < 50; ++step) {
      // Legendre's recurrence up to P_n; then the root of s P_n - P_(n-1), which is
      // (s^2 - 1) P'_n / n.
      double before = 1, here = s;
      for (int k = 2; k <= n; ++k) {
        const double next = ((2 * k - 1) * s * here - (k - 1) * before) / k;
        before = here;
        here = next;
      }
      const double change = (s * here - before) / ((n + 1) * here);
      s -= change;
      if (std::abs(change) < 1e-16) break;
    }
    x[i] = (s + 1) / 2;
  }
  x[0] = 0;
  x[n] = 1;
  // Mirrored exactly, so that the two sides of a shared edge agree to the last bit.
  for (int i = 0; i <= n / 2; ++i) {
    const double half = (x[i] + (1 - x[n - i])) / 2;
    x[i] = half;
    x[n - i] = 1 - half;
  }
  return x;
}

}  // namespace

const Eigen::VectorXd& lobatto_nodes(int order) {
  static const std::array<Eigen::VectorXd, highest_order> all = [] {
    std::array<Eigen::VectorXd, highest_order> nodes;
    for (int n = 1; n <= highest_order; ++n) nodes[static_cast<std::size_t>(n - 1)] = make_nodes(n);
    return nodes;
  }();
  return all.at(static_cast<std::size_t>(order - 1));
}

LineShapes line_shapes(int order, double x) {
  const auto& node = lobatto_nodes(order);
  LineShapes out{Eigen::VectorXd(order + 1), Eigen::VectorXd(order + 1)};
  for (int i = 0; i <= order; ++i) {
    double value = 1, slope = 0;
    for (int k = 0; k <= order; ++k) {
      if (k == i) continue;
      const double scale = 1 / (node[i] - node[k]);
      slope = (slope * (x - node[k]) + value) * scale;
      value *= (x - node[k]) * scale;
    }
    out.values[i] = value;
    out.slopes[i] = slope;
  }
  return out;
}

}  // namespace carillon::solvers::elements
