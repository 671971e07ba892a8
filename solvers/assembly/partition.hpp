#pragma once

#include <cstdint>
#include <vector>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::assembly {

/// Who owns which node. Nodes are renumbered so that each rank's are contiguous; on one rank they
/// keep their order. Nodes that no element uses take no part.
struct Partition {
  std::vector<std::int32_t> number;  ///< mesh node -> new number, -1 when unused
  std::vector<std::int32_t> node;    ///< new number -> mesh node
  std::vector<std::int32_t> first;   ///< ranks + 1: rank r owns numbers [first[r], first[r+1])

  std::int32_t node_count() const { return first.back(); }
  std::int32_t owned(int rank) const {
    const auto r = static_cast<std::size_t>(rank);
    return first[r + 1] - first[r];
  }
};

/// Cuts the elements' dual graph into `parts` of equal size (METIS, fixed seed); a node on a cut
/// goes to the part that has fewer nodes. Depends on its arguments only, so every rank computes
/// the same.
/// @throws core::SolverError  METIS failed
Partition partition(const mesh::TetMesh& mesh, int parts);

/// Part of each element when the elements' dual graph (elements that share a face) is cut into
/// parts of equal size (METIS, fixed seed).
/// @throws core::SolverError  METIS failed
std::vector<std::int32_t> element_parts(const mesh::TetMesh& mesh, int parts);

/// Elements around each node: those of node n are list[first[n]] to list[first[n + 1]], ascending.
struct NodeElements {
  std::vector<std::int32_t> first;
  std::vector<std::int32_t> list;
};
NodeElements elements_around_nodes(const mesh::TetMesh& mesh);

/// Rows of the node graph that a rank owns: for each owned number the numbers of all nodes that
/// share an element with it, itself among them, ascending.
struct NodeGraph {
  std::int32_t begin = 0;           ///< number of the first owned node
  std::vector<std::int64_t> first;  ///< owned + 1
  std::vector<std::int32_t> column;

  std::int32_t rows() const { return static_cast<std::int32_t>(first.size()) - 1; }
};
NodeGraph node_graph(const mesh::TetMesh& mesh, const Partition& partition,
                     const NodeElements& around, int rank);

/// Elimination order of a whole node graph (one rank) by nested dissection, METIS_NodeND.
/// @return order[k]: number of the node eliminated k-th
/// @throws core::SolverError  METIS failed
std::vector<std::int32_t> nested_dissection(const NodeGraph& graph);

}  // namespace carillon::solvers::assembly
