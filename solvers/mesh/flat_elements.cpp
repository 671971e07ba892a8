#include "solvers/mesh/flat_elements.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

namespace carillon::solvers::mesh {
namespace {

using Node = std::int32_t;
using FlatFace = std::array<Node, 3>;

constexpr double flat_fraction = 1e-9;

FlatFace face_opposite(std::span<const Node> corners, std::size_t i) {
  FlatFace face{corners[(i + 1) % 4], corners[(i + 2) % 4], corners[(i + 3) % 4]};
  std::sort(face.begin(), face.end());
  return face;
}

bool is_flat(const TetMesh& mesh, std::size_t element) {
  const auto corners = mesh.element(element);
  const auto at = [&](std::size_t i) { return mesh.nodes[static_cast<std::size_t>(corners[i])]; };
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < i; ++j) longest = std::max(longest, (at(i) - at(j)).norm());
  return six_volumes(mesh, element) / 6 < flat_fraction * std::pow(longest, 3);
}

/// What the boundary consists of, and how many elements share a node.
struct BodyBoundary {
  std::set<FlatFace> faces;
  std::set<std::pair<Node, Node>> edges;
  std::set<Node> nodes;
  std::map<Node, int> uses;

  explicit BodyBoundary(const TetMesh& mesh) {
    std::map<FlatFace, int> counts;
    for (std::size_t e = 0; e < mesh.element_count(); ++e) {
      for (std::size_t i = 0; i < 4; ++i) ++counts[face_opposite(mesh.element(e), i)];
      for (const Node node : mesh.element(e)) ++uses[node];
    }
    for (const auto& [face, count] : counts) {
      if (count != 1) continue;
      faces.insert(face);
      nodes.insert(face.begin(), face.end());
      edges.insert({{face[0], face[1]}, {face[0], face[2]}, {face[1], face[2]}});
    }
  }

  /// Whether the boundary stays a manifold when an element is taken off.
  bool can_lose(std::span<const Node> corners) const {
    std::vector<Node> inner;  // corners opposite to faces on the boundary
    Node other = -1;          // one that is opposite to a face inside
    for (std::size_t i = 0; i < 4; ++i) {
      if (faces.contains(face_opposite(corners, i)))
        inner.push_back(corners[i]);
      else
        other = corners[i];
    }
    switch (inner.size()) {
      case 1:  // its fourth corner comes to the boundary
        return !nodes.contains(inner[0]);
      case 2:  // the edge between the corners opposite to its outer faces comes to the boundary
        return !edges.contains(std::minmax(inner[0], inner[1]));
      case 3:  // the corner between its outer faces disappears
        return uses.at(other) == 1;
      default:
        return inner.size() == 4;  // all by itself
    }
  }
};

void drop_elements(TetMesh& mesh, const std::set<std::size_t>& dropped) {
  std::vector<Node> elements, regions;
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    if (dropped.contains(e)) continue;
    const auto corners = mesh.element(e);
    elements.insert(elements.end(), corners.begin(), corners.end());
    regions.push_back(mesh.regions[e]);
  }
  mesh.elements = std::move(elements);
  mesh.regions = std::move(regions);
}

}  // namespace

std::int64_t peel_flat_elements(TetMesh& mesh) {
  std::int64_t peeled = 0;
  for (;;) {
    std::vector<std::size_t> flat;
    for (std::size_t e = 0; e < mesh.element_count(); ++e)
      if (is_flat(mesh, e)) flat.push_back(e);
    if (flat.empty()) break;
    const BodyBoundary boundary(mesh);
    // Elements that share a node would change the boundary for each other: one layer at a time.
    std::set<std::size_t> dropped;
    std::set<Node> touched;
    for (const std::size_t e : flat) {
      const auto corners = mesh.element(e);
      const bool free = std::none_of(corners.begin(), corners.end(),
                                     [&](Node node) { return touched.contains(node); });
      if (!free || !boundary.can_lose(corners)) continue;
      dropped.insert(e);
      touched.insert(corners.begin(), corners.end());
    }
    if (dropped.empty()) break;
    drop_elements(mesh, dropped);
    peeled += static_cast<std::int64_t>(dropped.size());
  }
  if (peeled > 0) {
    drop_unused_nodes(mesh);
    if (!mesh.faces.empty()) mesh.faces = boundary_faces(mesh);
  }
  return peeled;
}

}  // namespace carillon::solvers::mesh
