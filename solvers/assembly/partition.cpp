#include "solvers/assembly/partition.hpp"

#include <metis.h>
#include <signal.h>

#include <algorithm>
#include <numeric>

#include "core/error.hpp"
#include "core/termination_blocked.hpp"

namespace carillon::solvers::assembly {
namespace {

static_assert(sizeof(idx_t) == sizeof(std::int32_t), "Debian's METIS counts in 32 bits");

/// Calls METIS, which takes SIGTERM for a fault of its own: its handler jumps out of whatever METIS
/// was doing, malloc() among it, and nobody hears of the signal. So none comes while it works; and
/// the former handlers, which METIS leaves for one signal only, are put back as they were.
template <class Call>
bool metis_succeeds(const Call& call) {
  const core::TerminationBlocked blocked;
  struct sigaction abort_action {};
  struct sigaction termination_action {};
  sigaction(SIGABRT, nullptr, &abort_action);
  sigaction(SIGTERM, nullptr, &termination_action);
  const int status = call();
  sigaction(SIGABRT, &abort_action, nullptr);
  sigaction(SIGTERM, &termination_action, nullptr);
  return status == METIS_OK;
}

}  // namespace

std::vector<std::int32_t> element_parts(const mesh::TetMesh& mesh, int parts) {
  if (parts <= 1) return std::vector<std::int32_t>(mesh.element_count(), 0);
  auto elements = static_cast<idx_t>(mesh.element_count());
  auto nodes = static_cast<idx_t>(mesh.nodes.size());
  std::vector<idx_t> start(mesh.element_count() + 1);
  std::vector<idx_t> corners;
  corners.reserve(4 * mesh.element_count());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto element = mesh.element(e).first(4);
    corners.insert(corners.end(), element.begin(), element.end());
    start[e + 1] = static_cast<idx_t>(corners.size());
  }
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = 1;
  idx_t shared = 3, count = parts, cut = 0;
  std::vector<idx_t> element_part(mesh.element_count()), node_part(mesh.nodes.size());
  if (!metis_succeeds([&] {
        return METIS_PartMeshDual(&elements, &nodes, start.data(), corners.data(), nullptr, nullptr,
                                  &shared, &count, nullptr, options, &cut, element_part.data(),
                                  node_part.data());
      })) {
    throw core::SolverError("METIS could not partition the mesh");
  }
  return element_part;
}

NodeElements elements_around_nodes(const mesh::TetMesh& mesh) {
  NodeElements around;
  around.first.assign(mesh.nodes.size() + 1, 0);
  for (const auto n : mesh.elements) ++around.first[static_cast<std::size_t>(n) + 1];
  std::partial_sum(around.first.begin(), around.first.end(), around.first.begin());
  around.list.resize(mesh.elements.size());
  auto next = around.first;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    for (const auto n : mesh.element(e)) {
      auto& place = next[static_cast<std::size_t>(n)];
      around.list[static_cast<std::size_t>(place++)] = static_cast<std::int32_t>(e);
    }
  }
  return around;
}

Partition partition(const mesh::TetMesh& mesh, int parts) {
  const auto around = elements_around_nodes(mesh);
  const std::vector<std::int32_t> element_part = element_parts(mesh, parts);

  std::vector<std::int32_t> owner(mesh.nodes.size(), -1);
  Partition out;
  std::vector<std::int32_t> load(static_cast<std::size_t>(parts), 0);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const auto begin = static_cast<std::size_t>(around.first[n]);
    const auto end = static_cast<std::size_t>(around.first[n + 1]);
    for (std::size_t i = begin; i < end; ++i) {
      const auto part = element_part[static_cast<std::size_t>(around.list[i])];
      if (owner[n] < 0 ||
          load[static_cast<std::size_t>(part)] < load[static_cast<std::size_t>(owner[n])]) {
        owner[n] = part;
      }
    }
    if (owner[n] >= 0) ++load[static_cast<std::size_t>(owner[n])];
  }

  out.first.assign(static_cast<std::size_t>(parts) + 1, 0);
  std::partial_sum(load.begin(), load.end(), out.first.begin() + 1);
  out.number.assign(mesh.nodes.size(), -1);
  out.node.resize(static_cast<std::size_t>(out.node_count()));
  auto next = out.first;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (owner[n] < 0) continue;
    const auto number = next[static_cast<std::size_t>(owner[n])]++;
    out.number[n] = number;
    out.node[static_cast<std::size_t>(number)] = static_cast<std::int32_t>(n);
  }
  return out;
}

NodeGraph node_graph(const mesh::TetMesh& mesh, const Partition& partition,
                     const NodeElements& around, int rank) {
  NodeGraph graph;
  graph.begin = partition.first[static_cast<std::size_t>(rank)];
  const auto rows = partition.owned(rank);
  graph.first.reserve(static_cast<std::size_t>(rows) + 1);
  graph.first.push_back(0);
  // A node is a neighbour once per row: `seen` remembers the last row that took it.
  std::vector<std::int32_t> seen(static_cast<std::size_t>(partition.node_count()), -1);
  for (std::int32_t row = 0; row < rows; ++row) {
    const auto node =
        static_cast<std::size_t>(partition.node[static_cast<std::size_t>(graph.begin + row)]);
    for (auto i = around.first[node]; i < around.first[node + 1]; ++i) {
      const auto e = static_cast<std::size_t>(around.list[static_cast<std::size_t>(i)]);
      for (const auto other : mesh.element(e)) {
        const auto number = partition.number[static_cast<std::size_t>(other)];
        auto& last = seen[static_cast<std::size_t>(number)];
        if (last == row) continue;
        last = row;
        graph.column.push_back(number);
      }
    }
    std::sort(graph.column.begin() + static_cast<std::ptrdiff_t>(graph.first.back()),
              graph.column.end());
    graph.first.push_back(static_cast<std::int64_t>(graph.column.size()));
  }
  return graph;
}

std::vector<std::int32_t> nested_dissection(const NodeGraph& graph) {
  auto nodes = static_cast<idx_t>(graph.rows());
  std::vector<idx_t> start = {0}, neighbours;
  neighbours.reserve(graph.column.size());
  for (idx_t n = 0; n < nodes; ++n) {
    const auto row = static_cast<std::size_t>(n);
    for (auto i = graph.first[row]; i < graph.first[row + 1]; ++i) {
      const auto other = graph.column[static_cast<std::size_t>(i)];
      if (other != n) neighbours.push_back(other);
    }
    start.push_back(static_cast<idx_t>(neighbours.size()));
  }
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = 1;
  // The best of three separators at each level: on solid bodies it saves some 7 % of the flops of
  // every factorisation.
  options[METIS_OPTION_NSEPS] = 3;
  std::vector<std::int32_t> order(static_cast<std::size_t>(nodes));
  std::vector<std::int32_t> place(static_cast<std::size_t>(nodes));
  if (!metis_succeeds([&] {
        return METIS_NodeND(&nodes, start.data(), neighbours.data(), nullptr, options, order.data(),
                            place.data());
      })) {
    throw core::SolverError("METIS could not order the unknowns");
  }
  return order;
}

}  // namespace carillon::solvers::assembly
