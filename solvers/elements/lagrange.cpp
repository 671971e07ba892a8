#include "solvers/elements/lagrange.hpp"

#include <cassert>
#include <cstddef>

namespace carillon::solvers::elements {
namespace {

constexpr int max_order = 5;

using Tuple3 = std::array<int, 3>;
using Tuple4 = std::array<int, 4>;

/// Appends a triangle's lattice in the documented order; inside it lies the lattice of a triangle
/// three orders lower, each index one larger.
void append_triangle(int order, int shift, std::vector<Tuple3>& out) {
  if (order < 0) return;
  if (order == 0) {
    out.push_back({shift, shift, shift});
    return;
  }
  for (std::size_t v = 0; v < 3; ++v) {
    Tuple3 node{shift, shift, shift};
    node[v] += order;
    out.push_back(node);
  }
  constexpr std::size_t edges[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  for (const auto& edge : edges) {
    for (int step = 1; step < order; ++step) {
      Tuple3 node{shift, shift, shift};
      node[edge[0]] += order - step;
      node[edge[1]] += step;
      out.push_back(node);
    }
  }
  append_triangle(order - 3, shift + 1, out);
}

std::vector<Tuple4> make_tetrahedron(int order) {
  std::vector<Tuple4> out;
  for (std::size_t v = 0; v < 4; ++v) {
    Tuple4 node{};
    node[v] = order;
    out.push_back(node);
  }
  constexpr std::size_t edges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  for (const auto& edge : edges) {
    for (int step = 1; step < order; ++step) {
      Tuple4 node{};
      node[edge[0]] = order - step;
      node[edge[1]] = step;
      out.push_back(node);
    }
  }
  std::vector<Tuple3> inside;
  append_triangle(order - 3, 1, inside);
  constexpr std::size_t faces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  for (const auto& face : faces) {
    for (const auto& tuple : inside) {
      Tuple4 node{};
      for (std::size_t k = 0; k < 3; ++k) node[face[k]] = tuple[k];
      out.push_back(node);
    }
  }
  if (order == 4) out.push_back({1, 1, 1, 1});
  // Inside lies the lattice of a tetrahedron four orders lower, each index one larger.
  if (order > 4) {
    for (Tuple4 node : make_tetrahedron(order - 4)) {
      for (int& index : node) ++index;
      out.push_back(node);
    }
  }
  return out;
}

/// Silvester's factor R_a(L) = prod_{i<a} (p L - i) / (i + 1) and its derivative, for every a.
struct SilvesterTable {
  std::array<double, max_order + 1> value;
  std::array<double, max_order + 1> slope;
};

SilvesterTable silvester(int order, double coordinate) {
  SilvesterTable table{};
  table.value[0] = 1;
  for (int a = 0; a < order; ++a) {
    const auto k = static_cast<std::size_t>(a);
    const double factor = (order * coordinate - a) / (a + 1);
    table.value[k + 1] = table.value[k] * factor;
    table.slope[k + 1] = table.slope[k] * factor + table.value[k] * order / (a + 1);
  }
  return table;
}

/// Shape functions of a simplex: the product of one factor for each barycentric coordinate.
template <int Corners>
Eigen::VectorXd shape_functions(int order, const Eigen::Matrix<double, Corners, 1>& barycentric,
                                const std::vector<std::array<int, Corners>>& lattice,
                                Eigen::Matrix<double, Eigen::Dynamic, Corners>* gradient) {
  std::array<SilvesterTable, Corners> tables;
  for (int c = 0; c < Corners; ++c) {
    tables[static_cast<std::size_t>(c)] = silvester(order, barycentric[c]);
  }
  const auto nodes = static_cast<Eigen::Index>(lattice.size());
  Eigen::VectorXd values(nodes);
  if (gradient) gradient->resize(nodes, Corners);
  for (Eigen::Index n = 0; n < nodes; ++n) {
    const auto& tuple = lattice[static_cast<std::size_t>(n)];
    double value = 1;
    for (std::size_t c = 0; c < Corners; ++c) {
      value *= tables[c].value[static_cast<std::size_t>(tuple[c])];
    }
    values[n] = value;
    if (!gradient) continue;
    for (std::size_t c = 0; c < Corners; ++c) {
      double slope = 1;
      for (std::size_t other = 0; other < Corners; ++other) {
        const auto& table = tables[other];
        const auto a = static_cast<std::size_t>(tuple[other]);
        slope *= other == c ? table.slope[a] : table.value[a];
      }
      (*gradient)(n, static_cast<Eigen::Index>(c)) = slope;
    }
  }
  return values;
}

}  // namespace

const std::vector<std::array<int, 4>>& tetrahedron_lattice(int order) {
  static const std::array<std::vector<Tuple4>, max_order> lattices = {
      make_tetrahedron(1), make_tetrahedron(2), make_tetrahedron(3), make_tetrahedron(4),
      make_tetrahedron(5)};
  return lattices.at(static_cast<std::size_t>(order - 1));
}

const std::vector<std::array<int, 3>>& triangle_lattice(int order) {
  static const std::array<std::vector<Tuple3>, max_order> lattices = [] {
    std::array<std::vector<Tuple3>, max_order> all;
    for (int p = 1; p <= max_order; ++p)
      append_triangle(p, 0, all[static_cast<std::size_t>(p - 1)]);
    return all;
  }();
  return lattices.at(static_cast<std::size_t>(order - 1));
}

Eigen::VectorXd tetrahedron_shape_functions(int order, const Eigen::Vector4d& barycentric,
                                            Eigen::Matrix<double, Eigen::Dynamic, 4>* gradient) {
  return shape_functions<4>(order, barycentric, tetrahedron_lattice(order), gradient);
}

Eigen::VectorXd triangle_shape_functions(int order, const Eigen::Vector3d& barycentric,
                                         Eigen::Matrix<double, Eigen::Dynamic, 3>* gradient) {
  return shape_functions<3>(order, barycentric, triangle_lattice(order), gradient);
}

}  // namespace carillon::solvers::elements
