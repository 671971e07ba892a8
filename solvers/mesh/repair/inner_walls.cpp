// Walls between solids (surface_topology.hpp).
#include <Eigen/Geometry>

#include "core/disjoint_sets.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

/// The side of a triangle that its normal looks to, and the other one.
std::size_t front_of(std::size_t triangle) {
  return 2 * triangle;
}
std::size_t back_of(std::size_t triangle) {
  return 2 * triangle + 1;
}

/// Sides that look at the same part of space.
core::DisjointSets parts_of_space(const SurfaceMesh& mesh) {
  core::DisjointSets parts(2 * mesh.triangles.size());
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> edge) {
    const std::vector<Blade> blades = blades_around(mesh, edge);
    for (std::size_t i = 0; i < blades.size(); ++i) {
      const Blade& blade = blades[i];
      const Blade& next = blades[(i + 1) % blades.size()];
      const auto here = static_cast<std::size_t>(blade.triangle);
      const auto there = static_cast<std::size_t>(next.triangle);
      parts.join(blade.backward ? back_of(here) : front_of(here),
                 next.backward ? front_of(there) : back_of(there));
    }
  });
  return parts;
}

/// For every side whether it looks at a solid.
std::vector<char> sides_of_solids(const SurfaceMesh& mesh) {
  core::DisjointSets parts = parts_of_space(mesh);
  std::vector<double> volume(parts.size(), 0), away(parts.size(), 0);
  const Vec3 origin = mesh.vertices.empty() ? Vec3::Zero() : mesh.vertices.front();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto corner = [&](std::size_t i) -> Vec3 {
      return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][i])] - origin;
    };
    const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    for (const auto& [side, sign] : {std::pair(front_of(t), -1.0), {back_of(t), 1.0}}) {
      const std::size_t part = parts.find(side);
      volume[part] += sign * corner(0).dot(normal);
      away[part] += sign * normal.norm();
    }
  }
  std::vector<char> solid(parts.size());
  for (std::size_t side = 0; side < solid.size(); ++side) {
    const std::size_t part = parts.find(side);
    solid[side] = volume[part] > 0 && away[part] > 0;
  }
  return solid;
}

}  // namespace

std::int64_t drop_inner_walls(SurfaceMesh& mesh) {
  const std::vector<char> solid = sides_of_solids(mesh);
  const auto component = edge_components(mesh.triangles);
  std::vector<char> divides(mesh.triangles.size(), 1);  // by component
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!solid[back_of(t)]) divides[static_cast<std::size_t>(component[t])] = 0;
  std::vector<Triangle> kept;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (!solid[front_of(t)] || !divides[static_cast<std::size_t>(component[t])])
      kept.push_back(mesh.triangles[t]);
  const auto dropped = static_cast<std::int64_t>(mesh.triangles.size() - kept.size());
  mesh.triangles = std::move(kept);
  return dropped;
}

}  // namespace carillon::solvers::mesh::repair
