// Cutting of surfaces where more than two triangles meet (surface_topology.hpp).
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/disjoint_sets.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

/// Pairs of triangles at an edge that bound the same wedge of material. Seen against the edge's
/// direction, low to high, a wedge begins at a triangle that walks the edge backward and ends at
/// the next one that walks it forward.
std::vector<std::pair<std::int32_t, std::int32_t>> wedges(const SurfaceMesh& mesh,
                                                          std::span<const EdgeUse> edge) {
  if (edge.size() == 2) {
    if (edge[0].forward == edge[1].forward) return {};
    return {{edge[0].triangle, edge[1].triangle}};
  }
  const Vec3& low = mesh.vertices[static_cast<std::size_t>(edge[0].low)];
  const Vec3 axis = (mesh.vertices[static_cast<std::size_t>(edge[0].high)] - low).normalized();
  const Vec3 u = axis.unitOrthogonal();
  const Vec3 v = axis.cross(u);
  struct Blade {
    double angle;
    bool backward;
    std::int32_t triangle;
  };
  std::vector<Blade> blades;
  for (const EdgeUse& use : edge) {
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(use.triangle)];
    const std::int32_t third = t[0] + t[1] + t[2] - use.low - use.high;
    const Vec3 w = mesh.vertices[static_cast<std::size_t>(third)] - low;
    // Rounded, so that blades in one plane count as one direction.
    const double angle = std::round(std::atan2(w.dot(v), w.dot(u)) * 1e9);
    blades.push_back({angle, !use.forward, use.triangle});
  }
  // In one direction a wedge ends before the next one begins.
  std::sort(blades.begin(), blades.end(), [](const Blade& a, const Blade& b) {
    return std::tie(a.angle, a.backward, a.triangle) < std::tie(b.angle, b.backward, b.triangle);
  });
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
