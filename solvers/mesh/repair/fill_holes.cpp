#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "solvers/mesh/repair/detail/hole_loops.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

/// Loops with more sides are openings, whatever their size.
constexpr std::size_t max_sides = 2000;
/// Holes of more than three sides together may have this fraction of the surface's area; what lacks
/// more is no surface of a body.
constexpr double max_area = 0.25;

const Vec3& at(const SurfaceMesh& mesh, std::int32_t v) {
  return mesh.vertices[static_cast<std::size_t>(v)];
}

double perimeter(const SurfaceMesh& mesh, const HoleLoop& loop) {
  double sum = 0;
  for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
    const std::int32_t next = loop.vertices[(i + 1) % loop.vertices.size()];
    sum += (at(mesh, next) - at(mesh, loop.vertices[i])).norm();
  }
  return sum;
}

double patch_area(const SurfaceMesh& mesh, const std::vector<Triangle>& patch) {
  double twice = 0;
  for (const Triangle& t : patch) {
    twice += (at(mesh, t[1]) - at(mesh, t[0])).cross(at(mesh, t[2]) - at(mesh, t[0])).norm();
  }
  return twice / 2;
}

/// Share of a rim's length along which the patch and the surface meet at no more than an angle.
double rim_share(const SurfaceMesh& mesh, const HoleLoop& loop, const std::vector<Triangle>& patch,
                 double angle_deg) {
  const auto normal = [&mesh](std::int32_t a, std::int32_t b, std::int32_t c) -> Vec3 {
    return (at(mesh, b) - at(mesh, a)).cross(at(mesh, c) - at(mesh, a));
  };
  std::map<std::pair<std::int32_t, std::int32_t>, Vec3> inside;
  for (const Triangle& t : patch) {
    for (std::size_t i = 0; i < 3; ++i) {
      inside[{t[i], t[(i + 1) % 3]}] = normal(t[0], t[1], t[2]);
    }
  }
  double met = 0;
  for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
    const std::int32_t from = loop.vertices[i];
    const std::int32_t to = loop.vertices[(i + 1) % loop.vertices.size()];
    const auto found = inside.find({from, to});
    if (found == inside.end()) continue;
    const Vec3 outside = normal(to, from, loop.opposite[i]);
    if (angle_between(found->second, outside) > angle_deg * std::numbers::pi / 180) continue;
    met += (at(mesh, to) - at(mesh, from)).norm();
  }
  return met / perimeter(mesh, loop);
}

/// Whether a hole is a defect of a closed surface rather than the mouth of a sheet: a patch folds
/// along the whole rim of a mouth. A patch in the plane of what surrounds it closes a face. Else a
/// few missing triangles may be large in a coarse mesh; a scan's holes may have many sides, but
/// they are small beside the whole.
bool is_defect(const SurfaceMesh& mesh, const HoleLoop& loop, const std::vector<Triangle>& patch,
               bool stands_alone, const HoleLimits& limits) {
  const std::size_t sides = loop.vertices.size();
  if (sides <= 3) return true;
  const double fraction = patch_area(mesh, patch) / limits.area;
  if (limits.gaps_only) return sides <= 8 && fraction < 0.02;
  constexpr double fold_deg = 40, flush_deg = 5, flush_share = 0.2;
  if (stands_alone && rim_share(mesh, loop, patch, fold_deg) < 0.1) return false;
  if (rim_share(mesh, loop, patch, flush_deg) > flush_share) return fraction < max_area;
  return (sides <= 8 && fraction < 0.1) ||
         (perimeter(mesh, loop) < 0.25 * limits.diagonal && fraction < 0.05) || fraction < 0.02;
}

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

}  // namespace

std::vector<HoleLoop> hole_loops(const SurfaceMesh& mesh) {
  struct Step {
    std::int32_t to, opposite;
    bool used = false;
  };
  // The hole walks an open edge against the sense of its triangle.
  std::map<std::int32_t, std::vector<Step>> steps;
  for_each_edge(edge_uses(mesh.triangles), [&](std::span<const EdgeUse> edge) {
    if (edge.size() != 1) return;
    const auto& [low, high, triangle, forward] = edge[0];
    const Triangle& t = mesh.triangles[static_cast<std::size_t>(triangle)];
    const std::int32_t third = t[0] + t[1] + t[2] - low - high;
    steps[forward ? high : low].push_back({forward ? low : high, third});
  });
  const auto unused = [&steps](std::int32_t v) -> Step* {
    const auto found = steps.find(v);
    if (found == steps.end()) return nullptr;
    for (Step& step : found->second) {
      if (!step.used) return &step;
    }
    return nullptr;
  };
  std::vector<HoleLoop> loops;
  for (auto& entry : steps) {
    while (unused(entry.first) != nullptr) {
      // A path that comes back to one of its vertices has closed a loop; the rest goes on.
      std::vector<std::int32_t> path{entry.first};
      std::vector<std::int32_t> opposite;
      std::map<std::int32_t, std::size_t> place{{entry.first, 0}};
      while (Step* step = unused(path.back())) {
        step->used = true;
        opposite.push_back(step->opposite);
        const auto [seen, fresh] = place.emplace(step->to, path.size());
        if (fresh) {
          path.push_back(step->to);
          continue;
        }
        const auto begin = static_cast<std::ptrdiff_t>(seen->second);
        HoleLoop loop{{path.begin() + begin, path.end()},
                      {opposite.begin() + begin, opposite.end()}};
        for (std::size_t i = seen->second + 1; i < path.size(); ++i) place.erase(path[i]);
        path.resize(seen->second + 1);
        opposite.resize(seen->second);
        if (loop.vertices.size() >= 3) loops.push_back(std::move(loop));
      }
    }
  }
  return loops;
}

HoleCount fill_holes(SurfaceMesh& mesh, const HoleLimits& limits) {
  HoleCount count;
  const auto loops = hole_loops(mesh);
  if (loops.empty()) return count;
  std::set<Triangle> present;
  for (const Triangle& t : mesh.triangles) present.insert(sorted(t));
  const auto leave = [&count, &mesh](const HoleLoop& loop) {
    ++count.left;
    count.largest_perimeter = std::max(count.largest_perimeter, perimeter(mesh, loop));
  };
  const auto component = edge_components(mesh.triangles);
  std::vector<std::int32_t> piece_of(mesh.vertices.size(), 0);
  for (std::size_t t = 0; t < component.size(); ++t)
    for (const std::int32_t v : mesh.triangles[t])
      piece_of[static_cast<std::size_t>(v)] = component[t];
  const std::vector<SurfaceMesh> pieces = split(mesh, component);
  std::vector<Box> boxes;
  for (const SurfaceMesh& piece : pieces) {
    boxes.emplace_back();
    if (piece.triangles.size() > 3) boxes.back() = bounding_box(piece.vertices);
  }
  // A piece may end inside of another one, where a patch does no harm.
  const auto stands_alone = [&](const HoleLoop& loop) {
    Vec3 middle = Vec3::Zero();
    for (const std::int32_t v : loop.vertices)
      middle += at(mesh, v) / static_cast<double>(loop.vertices.size());
    const auto own =
        static_cast<std::size_t>(piece_of[static_cast<std::size_t>(loop.vertices.front())]);
    for (std::size_t other = 0; other < pieces.size(); ++other) {
      const Box& box = boxes[other];
      const bool may_enclose =
          (middle - box.low).minCoeff() > 0 && (box.high - middle).minCoeff() > 0;
      if (other != own && may_enclose && std::abs(winding_number(pieces[other], middle)) > 0.5)
        return false;
    }
    return true;
  };
  double filled_area = 0;
  std::vector<Triangle> added;
  for (const HoleLoop& loop : loops) {
    const std::size_t sides = loop.vertices.size();
    std::vector<Triangle> patch;
    if (sides == 3) {
      patch.push_back({loop.vertices[0], loop.vertices[1], loop.vertices[2]});
    } else if (sides <= max_sides) {
      patch = triangulate_loop(mesh, loop);
    }
    // A single triangle's border is a hole too, but its own twin does not close it.
    const bool fresh = std::none_of(patch.begin(), patch.end(), [&present](const Triangle& t) {
      return present.count(sorted(t)) > 0;
    });
    const double size = patch_area(mesh, patch);
    if (patch.size() + 2 != sides || !fresh ||
        !is_defect(mesh, loop, patch, stands_alone(loop), limits)) {
      leave(loop);
      continue;
    }
    if (sides > 3) filled_area += size;
    for (const Triangle& t : patch) present.insert(sorted(t));
    added.insert(added.end(), patch.begin(), patch.end());
    ++count.filled;
  }
  if (filled_area > max_area * limits.area) {
    for (const HoleLoop& loop : loops) {
      count.largest_perimeter = std::max(count.largest_perimeter, perimeter(mesh, loop));
    }
    return {0, static_cast<std::int64_t>(loops.size()), count.largest_perimeter, 0};
  }
  count.area = filled_area;
  mesh.triangles.insert(mesh.triangles.end(), added.begin(), added.end());
  return count;
}

}  // namespace carillon::solvers::mesh::repair
