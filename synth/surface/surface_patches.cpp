#include "synth/surface/surface_patches.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <queue>
#include <set>

#include "core/numbers.hpp"

namespace carillon::synth::surface {

namespace {

using core::infinity;

/// A way over the surface, from triangle to triangle.
struct Way {
  double length;  ///< with turns [m]
  double turns;   ///< the turns' part of it [m]
  int triangle;
  bool operator>(const Way& other) const {
    return length != other.length ? length > other.length : triangle > other.triangle;
  }
};

Vec3 unit_normal(const OuterTriangles& surface, std::size_t t) {
  return surface.areas[t] > 0 ? Vec3(surface.area_vectors[t] / surface.areas[t]) : Vec3::Zero();
}

/// Follows ways from one triangle as long as `reached(way)` says so, shortest first.
template <class Reached>
void follow_ways(const OuterTriangles& surface, int start, double turn_length,
                 const Reached& reached) {
  std::priority_queue<Way, std::vector<Way>, std::greater<>> open;
  open.push({0, 0, start});
  while (!open.empty()) {
    const Way way = open.top();
    open.pop();
    if (!reached(way)) continue;
    const auto t = static_cast<std::size_t>(way.triangle);
    for (const int next : surface.neighbours[t]) {
      if (next < 0) continue;
      const auto u = static_cast<std::size_t>(next);
      const double turn = turn_length * (1 - unit_normal(surface, t).dot(unit_normal(surface, u)));
      const double step = (surface.centres[u] - surface.centres[t]).norm();
      open.push({way.length + step + turn, way.turns + turn, next});
    }
  }
}

/// Nearest of some centres for every triangle, by way over the surface.
struct Cells {
  std::vector<int> centres;      ///< triangles
  std::vector<int> cell;         ///< of each triangle
  std::vector<double> distance;  ///< of each triangle from its centre [m]
};

void add_centre(const OuterTriangles& surface, int centre, double turn_length, Cells& cells) {
  const int number = static_cast<int>(cells.centres.size());
  cells.centres.push_back(centre);
  follow_ways(surface, centre, turn_length, [&](const Way& way) {
    double& distance = cells.distance[static_cast<std::size_t>(way.triangle)];
    if (!(way.length < distance)) return false;
    distance = way.length;
    cells.cell[static_cast<std::size_t>(way.triangle)] = number;
    return true;
  });
}

Cells cells_about(const OuterTriangles& surface, const std::vector<int>& centres,
                  double turn_length) {
  Cells cells{
      {}, std::vector<int>(surface.size(), 0), std::vector<double>(surface.size(), infinity)};
  for (const int centre : centres) add_centre(surface, centre, turn_length, cells);
  return cells;
}

Cells far_apart(const OuterTriangles& surface, std::size_t count, double turn_length) {
  Cells cells = cells_about(surface, {0}, turn_length);
  while (cells.centres.size() < std::min(count, surface.size())) {
    const auto farthest = std::max_element(cells.distance.begin(), cells.distance.end());
    if (!(*farthest > 0)) break;
    add_centre(surface, static_cast<int>(farthest - cells.distance.begin()), turn_length, cells);
  }
  // Towards the middles of their cells (Lloyd).
  for (int round = 0; round < 2; ++round) {
    std::vector<Vec3> middle(cells.centres.size(), Vec3::Zero());
    std::vector<double> area(cells.centres.size(), 0);
    for (std::size_t t = 0; t < surface.size(); ++t) {
      const auto c = static_cast<std::size_t>(cells.cell[t]);
      middle[c] += surface.areas[t] * surface.centres[t];
      area[c] += surface.areas[t];
    }
    std::vector<int> centres = cells.centres;
    std::vector<double> best(centres.size(), infinity);
    for (std::size_t t = 0; t < surface.size(); ++t) {
      const auto c = static_cast<std::size_t>(cells.cell[t]);
      if (!(area[c] > 0)) continue;
      const double distance = (surface.centres[t] - middle[c] / area[c]).norm();
      if (distance >= best[c]) continue;
      best[c] = distance;
      centres[c] = static_cast<int>(t);
    }
    cells = cells_about(surface, centres, turn_length);
  }
  return cells;
}

double spacing_of(const OuterTriangles& surface, std::size_t count) {
  return std::sqrt(surface.area / static_cast<double>(std::min(count, surface.size())));
}

}  // namespace

SurfacePatches surface_patches(const OuterTriangles& surface, std::size_t count) {
  const double spacing = spacing_of(surface, count);
  const Cells cells = far_apart(surface, count, spacing);
  std::vector<std::vector<int>> members(cells.centres.size());
  for (std::size_t t = 0; t < surface.size(); ++t) {
    members[static_cast<std::size_t>(cells.cell[t])].push_back(static_cast<int>(t));
  }
  SurfacePatches patches;
  for (const std::vector<int>& patch : members) {
    double area = 0;
    Vec3 centre = Vec3::Zero(), normal = Vec3::Zero();
    for (const int member : patch) {
      const auto t = static_cast<std::size_t>(member);
      area += surface.areas[t];
      centre += surface.areas[t] * surface.centres[t];
      normal += surface.area_vectors[t];
    }
    if (!(area > 0)) continue;
    centre /= area;
    double radius = 0;
    std::vector<std::array<int, 2>> outline;
    for (const int member : patch) {
      const auto t = static_cast<std::size_t>(member);
      for (std::size_t side = 0; side < 3; ++side) {
        const int a = surface.mesh.triangles[t][side],
                  b = surface.mesh.triangles[t][(side + 1) % 3];
        radius =
            std::max(radius, (surface.mesh.vertices[static_cast<std::size_t>(a)] - centre).norm());
        const int next = surface.neighbours[t][side];
        if (next < 0 || cells.cell[static_cast<std::size_t>(next)] != cells.cell[t]) {
          outline.push_back({a, b});
        }
      }
    }
    patches.members.push_back(patch);
    patches.outline.push_back(std::move(outline));
    patches.centres.push_back(centre);
    patches.normals.push_back(normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3::Zero());
    patches.areas.push_back(area);
    patches.radii.push_back(radius);
  }
  patches.spacing = spacing_of(surface, patches.size());
  return patches;
}

Eigen::SparseMatrix<double> smooth_functions(const OuterTriangles& surface, std::size_t count) {
  const double spacing = spacing_of(surface, count);
  const Cells cells = far_apart(surface, count, spacing);
  double cover = 0;
  for (const double distance : cells.distance) {
    if (std::isfinite(distance)) cover = std::max(cover, distance);
  }
  const double reach = 2 * std::max(cover, 1e-9 * spacing);
  std::vector<Eigen::Triplet<double>> entries;
  std::vector<double> sums(surface.size(), 0);
  for (std::size_t c = 0; c < cells.centres.size(); ++c) {
    const Vec3 centre = surface.centres[static_cast<std::size_t>(cells.centres[c])];
    std::set<int> seen;
    follow_ways(surface, cells.centres[c], spacing, [&](const Way& way) {
      const auto t = static_cast<std::size_t>(way.triangle);
      // Ways from triangle to triangle are up to a half longer than straight ones.
      if (way.length - way.turns > 1.5 * reach || !seen.insert(way.triangle).second) return false;
      const double distance = (surface.centres[t] - centre).norm() + way.turns;
      if (distance >= reach) return way.turns < reach;
      const double weight = (1 - distance / reach) * (1 - distance / reach);
      entries.emplace_back(way.triangle, static_cast<int>(c), weight);
      sums[t] += weight;
      return true;
    });
  }
  for (Eigen::Triplet<double>& entry : entries) {
    entry = {entry.row(), entry.col(), entry.value() / sums[static_cast<std::size_t>(entry.row())]};
  }
  Eigen::SparseMatrix<double> functions(static_cast<Eigen::Index>(surface.size()),
                                        static_cast<Eigen::Index>(cells.centres.size()));
  functions.setFromTriplets(entries.begin(), entries.end());
  return functions;
}

std::vector<double> inscribed_radii(const OuterTriangles& surface, const SurfacePatches& patches) {
  std::vector<double> radii(surface.size(), infinity);
  for (std::size_t t = 0; t < surface.size(); ++t) {
    const Vec3 inward = -unit_normal(surface, t);
    double& radius = radii[t];
    for (std::size_t patch = 0; patch < patches.size(); ++patch) {
      // No point of the patch can be nearer, or lie deeper, than its sphere allows.
      const Vec3 way = patches.centres[patch] - surface.centres[t];
      const double minimum = std::max(0.0, way.norm() - patches.radii[patch]);
      const double deepest = inward.dot(way) + patches.radii[patch];
      if (deepest <= 0 || minimum * minimum >= 2 * deepest * radius) continue;
      for (const int member : patches.members[patch]) {
        const Vec3 to = surface.centres[static_cast<std::size_t>(member)] - surface.centres[t];
        const double depth = inward.dot(to);
        if (depth > 1e-6 * to.norm()) radius = std::min(radius, to.squaredNorm() / (2 * depth));
      }
    }
  }
  return radii;
}

double distance_from(const solvers::mesh::SurfaceMesh& surface, const Vec3& point) {
  double nearest = infinity;
  for (const solvers::mesh::Triangle& triangle : surface.triangles) {
    const auto corner = [&](std::size_t c) -> const Vec3& {
      return surface.vertices[static_cast<std::size_t>(triangle[c])];
    };
    const Vec3 normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    // Above the triangle: the height. Beside it: the nearest of the edges.
    bool above = normal.norm() > 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const Vec3 edge = corner((c + 1) % 3) - corner(c);
      const Vec3 to = point - corner(c);
      above = above && edge.cross(to).dot(normal) >= 0;
      const double length = edge.squaredNorm();
      const double along = length > 0 ? std::clamp(to.dot(edge) / length, 0.0, 1.0) : 0;
      nearest = std::min(nearest, (to - along * edge).norm());
    }
    if (above) {
      nearest = std::min(nearest, std::abs((point - corner(0)).dot(normal)) / normal.norm());
    }
  }
  return nearest;
}

}  // namespace carillon::synth::surface
