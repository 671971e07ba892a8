#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace carillon::solvers::elements {

using Corners = std::array<std::int32_t, 4>;

/// Nodes of every element of an order, shared wherever elements share a corner, an edge or a face.
struct NodeNumbering {
  std::vector<std::int32_t> elements;  ///< n x nodes_per_tetrahedron(order), in lattice order
  /// Where each node was met first, as an index into `elements`; corners keep their numbers, so
  /// nodes [0, vertex_count) are the vertices, then come those on edges, on faces and inside.
  std::vector<std::int64_t> first_use;
};

/// @param tetrahedra    corners of the elements, numbers below vertex_count, all of them used
/// @param order         1 to 5
NodeNumbering number_nodes(std::span<const Corners> tetrahedra, std::int32_t vertex_count,
                           int order);

}  // namespace carillon::solvers::elements
