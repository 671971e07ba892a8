#include "solvers/mesh/repair/detail/surface_topology.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/disjoint_sets.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

const Vec3& corner(const SurfaceMesh& mesh, const Triangle& t, std::size_t i) {
  return mesh.vertices[static_cast<std::size_t>(t[i])];
}

}  // namespace

std::size_t corner_of(const Triangle& t, std::int32_t vertex) {
  return static_cast<std::size_t>(std::find(t.begin(), t.end(), vertex) - t.begin());
}

std::vector<EdgeUse> edge_uses(const std::vector<Triangle>& triangles) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t a = triangles[t][i];
      const std::int32_t b = triangles[t][(i + 1) % 3];
      if (a == b) continue;
      uses.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), a < b});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& x, const EdgeUse& y) {
    return std::tie(x.low, x.high, x.triangle, x.forward) <
           std::tie(y.low, y.high, y.triangle, y.forward);
  });
  return uses;
}

std::vector<Blade> blades_around(const SurfaceMesh& mesh, std::span<const EdgeUse> edge) {
  const Vec3& low = mesh.vertices[static_cast<std::size_t>(edge[0].low)];
  const Vec3 axis = (mesh.vertices[static_cast<std::size_t>(edge[0].high)] - low).normalized();
  const Vec3 u = axis.unitOrthogonal();
  const Vec3 v = axis.cross(u);
  std::vector<Blade> blades;
  for (const EdgeUse& use : edge) {
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(use.triangle)];
    const std::int32_t third = t[0] + t[1] + t[2] - use.low - use.high;
    const Vec3 w = mesh.vertices[static_cast<std::size_t>(third)] - low;
    // Rounded, so that blades in one plane count as one direction.
    const double angle = std::round(std::atan2(w.dot(v), w.dot(u)) * 1e9);
    blades.push_back({angle, !use.forward, use.triangle});
  }
  std::sort(blades.begin(), blades.end(), [](const Blade& a, const Blade& b) {
    return std::tie(a.angle, a.backward, a.triangle) < std::tie(b.angle, b.backward, b.triangle);
  });
  return blades;
}

bool is_closed_and_oriented(const std::vector<Triangle>& triangles) {
  bool good = !triangles.empty();
  for_each_edge(edge_uses(triangles), [&good](std::span<const EdgeUse> edge) {
    good = good && edge.size() == 2 && edge[0].forward != edge[1].forward;
  });
  return good;
}

std::int64_t count_nonmanifold_vertices(const SurfaceMesh& mesh) {
  // Corners of triangles that share an edge at a vertex belong to one fan.
  core::DisjointSets fans(3 * mesh.triangles.size());
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> edge) {
    for (std::size_t k = 1; k < edge.size(); ++k) {
      for (const std::int32_t vertex : {edge[0].low, edge[0].high}) {
        const auto a = static_cast<std::size_t>(edge[0].triangle);
        const auto b = static_cast<std::size_t>(edge[k].triangle);
        fans.join(3 * a + corner_of(mesh.triangles[a], vertex),
                  3 * b + corner_of(mesh.triangles[b], vertex));
      }
    }
  });
  constexpr std::size_t none = static_cast<std::size_t>(-1);
  std::vector<std::size_t> fan(mesh.vertices.size(), none);
  std::vector<bool> several(mesh.vertices.size(), false);
  for (std::size_t c = 0; c < fans.size(); ++c) {
    const auto vertex = static_cast<std::size_t>(mesh.triangles[c / 3][c % 3]);
    if (fan[vertex] == none) fan[vertex] = fans.find(c);
    if (fan[vertex] != fans.find(c)) several[vertex] = true;
  }
  return std::count(several.begin(), several.end(), true);
}

std::int64_t orient_neighbours(SurfaceMesh& mesh) {
  const std::size_t count = mesh.triangles.size();
  // Neighbours across edges of exactly two triangles, and whether they disagree.
  std::vector<std::vector<std::pair<std::size_t, bool>>> neighbours(count);
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 2 || edge[0].triangle == edge[1].triangle) return;
    const bool disagree = edge[0].forward == edge[1].forward;
    const auto a = static_cast<std::size_t>(edge[0].triangle);
    const auto b = static_cast<std::size_t>(edge[1].triangle);
    neighbours[a].emplace_back(b, disagree);
    neighbours[b].emplace_back(a, disagree);
  });
  std::vector<bool> visited(count, false);
  std::vector<bool> turned(count, false);
  std::vector<std::size_t> piece;
  std::int64_t changed = 0;
  for (std::size_t seed = 0; seed < count; ++seed) {
    if (visited[seed]) continue;
    piece.assign(1, seed);
    visited[seed] = true;
    double kept_area = 0;
    double turned_area = 0;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const std::size_t t = piece[i];
      const Triangle& tri = mesh.triangles[t];
      const Vec3& a = corner(mesh, tri, 0);
      (turned[t] ? turned_area : kept_area) +=
          (corner(mesh, tri, 1) - a).cross(corner(mesh, tri, 2) - a).norm();
      for (const auto& [next, disagree] : neighbours[t]) {
        if (visited[next]) continue;
        visited[next] = true;
        turned[next] = turned[t] != disagree;
        piece.push_back(next);
      }
    }
    for (const std::size_t t : piece) {
      if (turned[t] == (turned_area > kept_area)) continue;
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      ++changed;
    }
  }
  return changed;
}

void reverse(SurfaceMesh& mesh, const std::vector<std::int32_t>& component, std::int32_t c) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (component[t] == c) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  }
}

SurfaceMesh join(std::span<const SurfaceMesh> pieces) {
  SurfaceMesh mesh;
  for (const SurfaceMesh& piece : pieces) {
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), piece.vertices.begin(), piece.vertices.end());
    for (const Triangle& t : piece.triangles) {
      mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  return mesh;
}

std::vector<std::vector<std::size_t>> enclosing_pieces(std::span<const SurfaceMesh> pieces) {
  std::vector<Box> boxes;
  for (const SurfaceMesh& piece : pieces) boxes.push_back(bounding_box(piece.vertices));
  std::vector<std::vector<std::size_t>> around(pieces.size());
  for (std::size_t inner = 0; inner < pieces.size(); ++inner) {
    for (std::size_t outer = 0; outer < pieces.size(); ++outer) {
      const bool fits = (boxes[inner].low.array() > boxes[outer].low.array()).all() &&
                        (boxes[inner].high.array() < boxes[outer].high.array()).all();
      if (fits && std::abs(winding_number(pieces[outer], pieces[inner].vertices.front())) > 0.5) {
        around[inner].push_back(outer);
      }
    }
  }
  return around;
}

}  // namespace carillon::solvers::mesh::repair
