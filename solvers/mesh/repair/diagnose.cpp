#include <algorithm>
#include <cmath>
#include <set>

#include "solvers/mesh/repair/detail/intersections.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"
#include "solvers/mesh/repair/repair.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

/// More intersections than this say nothing new.
constexpr std::size_t pair_limit = 10000;

void count_edges(const SurfaceMesh& mesh, Diagnosis& d) {
  for_each_edge(edge_uses(mesh.triangles), [&d](std::span<const EdgeUse> edge) {
    d.boundary_edges += edge.size() == 1;
    d.nonmanifold_edges += edge.size() > 2;
    d.misoriented_edges += edge.size() == 2 && edge[0].forward == edge[1].forward;
  });
}

/// Components that lie inside another one or meet one, counted on the welded surface; returns
/// whether every closed piece looks away from the material: outer ones outward, cavities inward.
bool count_pieces(const SurfaceMesh& mesh, Diagnosis& d) {
  SurfaceMesh welded = mesh;
  weld(welded);
  drop_collapsed(welded);
  drop_twins(welded);
  orient_neighbours(welded);
  const auto component = edge_components(welded.triangles);
  const auto pairs = intersecting_pairs(welded, pair_limit);
  d.self_intersections = static_cast<std::int64_t>(pairs.size());

  std::set<std::int32_t> touching;
  for (const auto& [s, t] : pairs) {
    if (component[s] != component[t]) touching.insert({component[s], component[t]});
  }
  std::vector<std::int32_t> owner(welded.vertices.size(), -1);
  for (std::size_t t = 0; t < welded.triangles.size(); ++t) {
    for (const std::int32_t v : welded.triangles[t]) {
      std::int32_t& first = owner[static_cast<std::size_t>(v)];
      if (first < 0) first = component[t];
      if (first != component[t]) touching.insert({first, component[t]});
    }
  }
  d.touching_components = static_cast<std::int64_t>(touching.size());

  std::vector<SurfaceMesh> closed;
  for (SurfaceMesh& piece : split(welded, component)) {
    if (is_closed_and_oriented(piece.triangles)) closed.push_back(std::move(piece));
  }
  bool outward = true;
  const auto around = enclosing_pieces(closed);
  for (std::size_t i = 0; i < closed.size(); ++i) {
    d.nested_components += !around[i].empty();
    const bool cavity = around[i].size() % 2 == 1;
    outward = outward && (signed_volume(closed[i]) < 0) == cavity;
  }
  return outward;
}

}  // namespace

Diagnosis diagnose(const SurfaceMesh& mesh) {
  Diagnosis d;
  d.vertices = static_cast<std::int64_t>(mesh.vertices.size());
  d.triangles = static_cast<std::int64_t>(mesh.triangles.size());
  const auto first = first_at_place(mesh.vertices);
  for (std::size_t v = 0; v < first.size(); ++v) {
    d.duplicate_vertices += first[v] != static_cast<std::int32_t>(v);
  }
  SurfaceMesh copy = mesh;
  d.unreferenced_vertices = drop_unreferenced(copy);
  d.degenerate_triangles = static_cast<std::int64_t>(degenerate_triangles(mesh).size());
  d.duplicate_triangles = drop_twins(copy);
  count_edges(mesh, d);
  d.nonmanifold_vertices = count_nonmanifold_vertices(mesh);
  const auto component = edge_components(mesh.triangles);
  for (const std::int32_t c : component) d.components = std::max<std::int64_t>(d.components, c + 1);
  const bool outward = count_pieces(mesh, d);

  d.closed = d.triangles > 0 && d.boundary_edges == 0 && d.nonmanifold_edges == 0;
  d.clean = d.closed && outward && d.duplicate_vertices == 0 && d.unreferenced_vertices == 0 &&
            d.degenerate_triangles == 0 && d.duplicate_triangles == 0 &&
            d.nonmanifold_vertices == 0 && d.misoriented_edges == 0 && d.self_intersections == 0;
  d.volume = signed_volume(mesh);
  d.area = area(mesh);
  const Vec3 extent = bounding_box(mesh.vertices).extent();
  d.extent = {extent.x(), extent.y(), extent.z()};
  return d;
}

}  // namespace carillon::solvers::mesh::repair
