#include "solvers/mesh/weld.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

namespace carillon::solvers::mesh {

std::vector<std::int32_t> first_at_place(const std::vector<Vec3>& points) {
  std::vector<std::int32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto place = [&](std::int32_t v) {
    const Vec3& p = points[static_cast<std::size_t>(v)];
    return std::array{p.x(), p.y(), p.z()};
  };
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    const auto pa = place(a);
    const auto pb = place(b);
    return pa == pb ? a < b : pa < pb;
  });
  std::vector<std::int32_t> first(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && place(order[i]) == place(order[i - 1]);
    first[static_cast<std::size_t>(order[i])] =
        same ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  return first;
}

std::int64_t merge_vertices(SurfaceMesh& mesh, const std::vector<std::int32_t>& representative) {
  std::int64_t merged = 0;
  for (std::size_t v = 0; v < representative.size(); ++v) {
    merged += representative[v] != static_cast<std::int32_t>(v);
  }
  if (merged == 0) return 0;
  std::vector<std::int32_t> renumbered(mesh.vertices.size(), -1);
  std::int32_t next = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (representative[v] != static_cast<std::int32_t>(v)) continue;
    mesh.vertices[static_cast<std::size_t>(next)] = mesh.vertices[v];
    renumbered[v] = next++;
  }
  mesh.vertices.resize(static_cast<std::size_t>(next));
  for (Triangle& t : mesh.triangles) {
    for (std::int32_t& v : t) {
      v = renumbered[static_cast<std::size_t>(representative[static_cast<std::size_t>(v)])];
    }
  }
  return merged;
}

std::int64_t weld(SurfaceMesh& mesh) {
  return merge_vertices(mesh, first_at_place(mesh.vertices));
}

std::int64_t drop_unreferenced(SurfaceMesh& mesh) {
  std::vector<std::int32_t> renumbered(mesh.vertices.size(), -1);
  for (const Triangle& t : mesh.triangles) {
    for (const std::int32_t v : t) renumbered[static_cast<std::size_t>(v)] = 0;
  }
  std::int32_t next = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (renumbered[v] < 0) continue;
    mesh.vertices[static_cast<std::size_t>(next)] = mesh.vertices[v];
    renumbered[v] = next++;
  }
  const auto dropped = static_cast<std::int64_t>(mesh.vertices.size()) - next;
  mesh.vertices.resize(static_cast<std::size_t>(next));
  for (Triangle& t : mesh.triangles) {
    for (std::int32_t& v : t) v = renumbered[static_cast<std::size_t>(v)];
  }
  return dropped;
}

}  // namespace carillon::solvers::mesh
