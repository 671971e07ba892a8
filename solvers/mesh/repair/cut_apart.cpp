// Cutting of surfaces where more than two triangles meet (surface_topology.hpp).
#include <utility>

#include "core/disjoint_sets.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

/// Pairs of triangles at an edge that bound the same wedge of material: it begins at a triangle
/// that walks the edge backward and ends at the next one that walks it forward.
std::vector<std::pair<std::int32_t, std::int32_t>> wedges(const SurfaceMesh& mesh,
                                                          std::span<const EdgeUse> edge) {
  if (edge.size() == 2) {
    if (edge[0].forward == edge[1].forward) return {};
    return {{edge[0].triangle, edge[1].triangle}};
  }
  const std::vector<Blade> blades = blades_around(mesh, edge);
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  for (std::size_t i = 0; i < blades.size(); ++i) {
    const Blade& next = blades[(i + 1) % blades.size()];
    if (blades[i].backward && !next.backward) pairs.emplace_back(blades[i].triangle, next.triangle);
  }
  return pairs;
}

}  // namespace

std::int64_t cut_apart(SurfaceMesh& mesh) {
  // Corners that stay together are those of triangles that bound the same wedge at an edge.
  core::DisjointSets fans(3 * mesh.triangles.size());
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> edge) {
    for (const auto& [first, second] : wedges(mesh, edge)) {
      const auto a = static_cast<std::size_t>(first);
      const auto b = static_cast<std::size_t>(second);
      for (const std::int32_t vertex : {edge[0].low, edge[0].high}) {
        fans.join(3 * a + corner_of(mesh.triangles[a], vertex),
                  3 * b + corner_of(mesh.triangles[b], vertex));
      }
    }
  });
  // The first fan of a vertex keeps it, the others get copies.
  constexpr std::int32_t none = -1;
  std::vector<std::int32_t> vertex_of_fan(fans.size(), none);
  std::vector<char> taken(mesh.vertices.size(), 0);
  std::int64_t copies = 0;
  for (std::size_t c = 0; c < fans.size(); ++c) {
    std::int32_t& vertex = mesh.triangles[c / 3][c % 3];
    std::int32_t& assigned = vertex_of_fan[fans.find(c)];
    if (assigned == none) {
      assigned = vertex;
      if (taken[static_cast<std::size_t>(vertex)]) {
        const Vec3 place = mesh.vertices[static_cast<std::size_t>(vertex)];
        assigned = static_cast<std::int32_t>(mesh.vertices.size());
        mesh.vertices.push_back(place);
        ++copies;
      } else {
        taken[static_cast<std::size_t>(vertex)] = 1;
      }
    }
    vertex = assigned;
  }
  return copies;
}

}  // namespace carillon::solvers::mesh::repair
