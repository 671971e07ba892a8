#include "solvers/mesh/readers/detail/msh_elements.hpp"

#include <cstddef>

namespace carillon::solvers::mesh::readers {
namespace {

constexpr MshElementKind kinds[] = {
    {1, 2, 1, "line"},
    {2, 3, 2, "triangle"},
    {3, 4, 2, "quadrangle"},
    {4, 4, 3, "4-node tetrahedron", 1},
    {5, 8, 3, "hexahedron"},
    {6, 6, 3, "prism"},
    {7, 5, 3, "pyramid"},
    {8, 3, 1, "3-node line"},
    {9, 6, 2, "6-node triangle"},
    {10, 9, 2, "9-node quadrangle"},
    {11, 10, 3, "10-node tetrahedron", 2},
    {12, 27, 3, "27-node hexahedron"},
    {13, 18, 3, "18-node prism"},
    {14, 14, 3, "14-node pyramid"},
    {15, 1, 0, "point"},
    {16, 8, 2, "8-node quadrangle"},
    {17, 20, 3, "20-node hexahedron"},
    {18, 15, 3, "15-node prism"},
    {19, 13, 3, "13-node pyramid"},
    {20, 9, 2, "9-node incomplete triangle"},
    {21, 10, 2, "10-node triangle"},
    {22, 12, 2, "12-node incomplete triangle"},
    {23, 15, 2, "15-node triangle"},
    {24, 15, 2, "15-node incomplete triangle"},
    {25, 21, 2, "21-node triangle"},
    {26, 4, 1, "4-node line"},
    {27, 5, 1, "5-node line"},
    {28, 6, 1, "6-node line"},
    {29, 20, 3, "20-node tetrahedron", 3},
    {30, 35, 3, "35-node tetrahedron", 4},
    {31, 56, 3, "56-node tetrahedron"},
    {36, 16, 2, "16-node quadrangle"},
    {37, 25, 2, "25-node quadrangle"},
    {38, 36, 2, "36-node quadrangle"},
    {92, 64, 3, "64-node hexahedron"},
    {93, 125, 3, "125-node hexahedron"},
};

using Tuple = std::array<int, 4>;

/// A walk between two corners of a sub-simplex: `steps` points strictly between them.
void add_edge(const Tuple& from, const Tuple& to, int order, std::vector<Tuple>& points) {
  for (int k = 1; k < order; ++k) {
    Tuple p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = from[i] + (to[i] - from[i]) / order * k;
    points.push_back(p);
  }
}

/// Corners a, b, c of a triangular lattice of an order (0: the one point where they meet), all its
/// points: corners, edges (ab)(bc)(ca), then the same inside.
void add_triangle(Tuple a, Tuple b, Tuple c, int order, std::vector<Tuple>& points) {
  if (order < 0) return;
  points.push_back(a);
  if (order == 0) return;
  points.push_back(b);
  points.push_back(c);
  add_edge(a, b, order, points);
  add_edge(b, c, order, points);
  add_edge(c, a, order, points);
  if (order < 3) return;
  // Corners of the inner triangle: one lattice step away from both sides that meet in a corner.
  Tuple inner_a, inner_b, inner_c;
  for (std::size_t i = 0; i < 4; ++i) {
    const int ab = (b[i] - a[i]) / order;
    const int ac = (c[i] - a[i]) / order;
    inner_a[i] = a[i] + ab + ac;
    inner_b[i] = b[i] - 2 * ab + ac;
    inner_c[i] = c[i] - 2 * ac + ab;
  }
  add_triangle(inner_a, inner_b, inner_c, order - 3, points);
}

}  // namespace

const MshElementKind* find_msh_element(std::int64_t number) {
  for (const MshElementKind& kind : kinds) {
    if (kind.number == number) return &kind;
  }
  return nullptr;
}

std::vector<Tuple> gmsh_tetrahedron_lattice(int order) {
  std::array<Tuple, 4> corner{};
  for (std::size_t i = 0; i < 4; ++i) corner[i][i] = order;
  std::vector<Tuple> points(corner.begin(), corner.end());
  // MTetrahedron::edges_tetra and faces_tetra.
  static constexpr std::size_t edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}};
  static constexpr std::size_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {3, 1, 2}};
  for (const auto& edge : edges) add_edge(corner[edge[0]], corner[edge[1]], order, points);
  for (const auto& face : faces) {
    std::vector<Tuple> all;
    add_triangle(corner[face[0]], corner[face[1]], corner[face[2]], order, all);
    // Those of the rim are there already.
    points.insert(points.end(), all.begin() + 3 * order, all.end());
  }
  // Orders 1 to 3 have no node inside, order 4 has one.
  if (order == 4) points.push_back({1, 1, 1, 1});
  return points;
}

}  // namespace carillon::solvers::mesh::readers
