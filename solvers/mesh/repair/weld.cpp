// Merging of vertices and removal of what does not count (surface_topology.hpp).
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "solvers/mesh/repair/detail/surface_topology.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

bool collapsed(const Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// Vertices of edges that have one triangle only, and the number of those edges.
std::pair<std::vector<std::int32_t>, std::int64_t> border(const std::vector<Triangle>& triangles) {
  std::vector<std::int32_t> vertices;
  std::int64_t edges = 0;
  for_each_edge(edge_uses(triangles), [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 1) return;
    ++edges;
    vertices.insert(vertices.end(), {edge[0].low, edge[0].high});
  });
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return {std::move(vertices), edges};
}

/// Drops the triangles that are marked, and their entries in `along`; returns how many.
std::int64_t keep_only(SurfaceMesh& mesh, std::vector<char>& along,
                       const std::vector<char>& dropped) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (dropped[t]) continue;
    along[kept] = along[t];
    mesh.triangles[kept++] = mesh.triangles[t];
  }
  const std::size_t count = mesh.triangles.size() - kept;
  mesh.triangles.resize(kept);
  along.resize(kept);
  return static_cast<std::int64_t>(count);
}

/// Two triangles back to back that stand out of a surface, or cross its inside, bound nothing:
/// patches of triangles that had a twin are dropped when they hang on the rest by edges of three
/// triangles and leave no open edge behind.
std::int64_t drop_fins(SurfaceMesh& mesh, std::vector<char>& had_twin) {
  std::vector<Triangle> suspects;
  std::vector<std::size_t> index;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!had_twin[t]) continue;
    suspects.push_back(mesh.triangles[t]);
    index.push_back(t);
  }
  const auto patch = edge_components(suspects);
  std::vector<std::int32_t> patch_of(mesh.triangles.size(), -1);
  for (std::size_t i = 0; i < index.size(); ++i) patch_of[index[i]] = patch[i];
  std::vector<char> hangs(suspects.size(), 0);
  std::vector<char> needed(suspects.size(), 0);
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> edge) {
    for (const EdgeUse& use : edge) {
      const std::int32_t p = patch_of[static_cast<std::size_t>(use.triangle)];
      if (p < 0) continue;
      const auto own = std::count_if(edge.begin(), edge.end(), [&](const EdgeUse& other) {
        return patch_of[static_cast<std::size_t>(other.triangle)] == p;
      });
      const auto others = static_cast<std::ptrdiff_t>(edge.size()) - own;
      if (others >= 2) hangs[static_cast<std::size_t>(p)] = 1;
      if (others == 1) needed[static_cast<std::size_t>(p)] = 1;
    }
  });
  std::vector<char> fin(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < fin.size(); ++t) {
    const auto p = static_cast<std::size_t>(std::max(patch_of[t], 0));
    fin[t] = patch_of[t] >= 0 && hangs[p] && !needed[p];
  }
  return keep_only(mesh, had_twin, fin);
}

using Cell = std::array<std::int64_t, 3>;

Cell cell_of(const Vec3& point, double size) {
  return {std::llround(point.x() / size), std::llround(point.y() / size),
          std::llround(point.z() / size)};
}

}  // namespace

std::int64_t weld_borders(SurfaceMesh& mesh, double distance) {
  const auto [candidates, open_before] = border(mesh.triangles);
  std::vector<std::int32_t> representative(mesh.vertices.size());
  std::iota(representative.begin(), representative.end(), 0);
  // Cells as wide as the distance: partners are in the same cell or in one beside it.
  std::map<Cell, std::vector<std::int32_t>> cells;
  for (const std::int32_t v : candidates) {
    const Vec3& p = mesh.vertices[static_cast<std::size_t>(v)];
    const Cell home = cell_of(p, distance);
    std::int32_t best = -1;
    double best_distance = distance;
    for (int k = 0; k < 27; ++k) {
      const auto cell =
          cells.find({home[0] + k % 3 - 1, home[1] + k / 3 % 3 - 1, home[2] + k / 9 - 1});
      if (cell == cells.end()) continue;
      for (const std::int32_t other : cell->second) {
        const double d = (mesh.vertices[static_cast<std::size_t>(other)] - p).norm();
        if (d <= best_distance) {
          best = other;
          best_distance = d;
        }
      }
    }
    if (best >= 0) {
      representative[static_cast<std::size_t>(v)] = best;
    } else {
      cells[home].push_back(v);
    }
  }
  SurfaceMesh welded = mesh;
  const std::int64_t merged = merge_vertices(welded, representative);
  if (merged == 0) return 0;
  SurfaceMesh checked = welded;
  drop_collapsed(checked);
  if (border(checked.triangles).second >= open_before) return 0;
  mesh = std::move(welded);
  return merged;
}

std::int64_t drop_collapsed(SurfaceMesh& mesh) {
  return static_cast<std::int64_t>(std::erase_if(mesh.triangles, collapsed));
}

std::int64_t drop_twins(SurfaceMesh& mesh) {
  std::vector<std::pair<Triangle, std::size_t>> sorted;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Triangle key = mesh.triangles[t];
    std::sort(key.begin(), key.end());
    sorted.emplace_back(key, t);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<char> twin(mesh.triangles.size(), 0);
  std::vector<char> had_twin(mesh.triangles.size(), 0);
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].first != sorted[i - 1].first) continue;
    twin[sorted[i].second] = 1;
    if (!twin[sorted[i - 1].second]) had_twin[sorted[i - 1].second] = 1;
  }
  std::int64_t dropped = keep_only(mesh, had_twin, twin);
  if (dropped > 0) dropped += drop_fins(mesh, had_twin);
  return dropped;
}

}  // namespace carillon::solvers::mesh::repair
