#include "solvers/mesh/repair/detail/pieces.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/disjoint_sets.hpp"
#include "solvers/mesh/repair/detail/intersections.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

/// Enough to find every pair of pieces that meet in all but absurd input.
constexpr std::size_t piece_pair_limit = 1000000;

void turn_over(SurfaceMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

/// Groups of pieces that meet; nothing when a piece meets itself.
std::optional<std::vector<std::vector<std::size_t>>> meeting_groups(
    const SurfaceMesh& mesh, const std::vector<std::int32_t>& component, std::size_t pieces) {
  core::DisjointSets meeting(pieces);
  for (const auto& [s, t] : intersecting_pairs(mesh, piece_pair_limit)) {
    if (component[s] == component[t]) return {};
    meeting.join(static_cast<std::size_t>(component[s]), static_cast<std::size_t>(component[t]));
  }
  std::map<std::size_t, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < pieces; ++i) members[meeting.find(i)].push_back(i);
  std::vector<std::vector<std::size_t>> groups;
  for (auto& entry : members) groups.push_back(std::move(entry.second));
  return groups;
}

/// Turns pieces so that they bound material, and leaves out those inside of it.
std::vector<SurfaceMesh> settle_nesting(std::vector<SurfaceMesh> pieces, bool trusted,
                                        std::vector<std::string>& actions) {
  const auto around = enclosing_pieces(pieces);
  // Outer pieces first: an inner one is judged by what was decided about those around it.
  std::vector<std::size_t> order(pieces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&around](std::size_t a, std::size_t b) {
    return around[a].size() < around[b].size();
  });
  std::vector<bool> outward(pieces.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) outward[i] = signed_volume(pieces[i]) > 0;
  const std::vector<bool> as_read = outward;
  std::vector<bool> kept(pieces.size(), true);
  std::int64_t turned = 0, swallowed = 0, cavities = 0;
  for (const std::size_t i : order) {
    // The innermost kept piece around this one, and the outermost, which tells whether the whole
    // family was read inside out.
    const std::size_t* parent = nullptr;
    const std::size_t* root = nullptr;
    for (const std::size_t& outer : around[i]) {
      if (!kept[outer]) continue;
      if (parent == nullptr || around[outer].size() > around[*parent].size()) parent = &outer;
      if (root == nullptr || around[outer].size() < around[*root].size()) root = &outer;
    }
    const bool wanted = parent == nullptr || !outward[*parent];
    const bool family_inside_out = root != nullptr && !as_read[*root];
    const bool says = as_read[i] != family_inside_out;
    if (parent != nullptr && trusted && says != wanted) {
      kept[i] = false;
      ++swallowed;
      continue;
    }
    turned += outward[i] != wanted;
    if (outward[i] != wanted) turn_over(pieces[i]);
    outward[i] = wanted;
    cavities += !wanted;
  }
  if (turned > 0) actions.push_back(fmt::format("turned {} closed piece(s) over", turned));
  if (cavities > 0) actions.push_back(fmt::format("kept {} inner piece(s) as cavities", cavities));
  if (swallowed > 0) {
    actions.push_back(fmt::format("removed {} piece(s) that lay inside the material", swallowed));
  }
  std::vector<SurfaceMesh> result;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (kept[i]) result.push_back(std::move(pieces[i]));
  }
  return result;
}

}  // namespace

std::int64_t drop_debris(SurfaceMesh& mesh) {
  const auto component = edge_components(mesh.triangles);
  const auto pieces = split(mesh, component);
  if (pieces.size() < 2) return 0;
  double total_volume = 0;
  double total_area = 0;
  std::vector<bool> closed;
  for (const SurfaceMesh& piece : pieces) {
    closed.push_back(is_closed_and_oriented(piece.triangles));
    total_area += area(piece);
    if (closed.back()) total_volume += std::abs(signed_volume(piece));
  }
  const bool any_closed = total_volume > 0;
  std::vector<SurfaceMesh> kept;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const bool debris = closed[i] ? std::abs(signed_volume(pieces[i])) < 1e-6 * total_volume
                                  : any_closed && area(pieces[i]) < 0.01 * total_area;
    if (!debris) kept.push_back(pieces[i]);
  }
  const auto dropped = static_cast<std::int64_t>(pieces.size() - kept.size());
  if (dropped > 0) mesh = join(kept);
  return dropped;
}

double nested_volume(const SurfaceMesh& mesh) {
  const auto pieces = split(mesh, edge_components(mesh.triangles));
  const auto around = enclosing_pieces(pieces);
  double volume = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const double own = std::abs(signed_volume(pieces[i]));
    volume += around[i].size() % 2 == 1 ? -own : own;
  }
  return volume;
}

std::optional<SurfaceMesh> resolve_pieces(const SurfaceMesh& mesh, bool trusted,
                                          std::vector<std::string>& actions) {
  const auto component = edge_components(mesh.triangles);
  std::vector<SurfaceMesh> pieces = split(mesh, component);
  const auto groups = meeting_groups(mesh, component, pieces.size());
  if (!groups) return {};

  std::vector<SurfaceMesh> bodies;
  for (const auto& group : *groups) {
    if (group.size() == 1) {
      bodies.push_back(std::move(pieces[group[0]]));
      continue;
    }
    std::vector<SurfaceMesh> operands;
    for (const std::size_t i : group) {
      if (signed_volume(pieces[i]) < 0) turn_over(pieces[i]);
      operands.push_back(std::move(pieces[i]));
    }
    auto both = unite(operands);
    if (!both) return {};
    actions.push_back(fmt::format("united {} pieces that meet", group.size()));
    for (SurfaceMesh& part : split(*both, edge_components(both->triangles))) {
      bodies.push_back(std::move(part));
    }
  }
  bodies = settle_nesting(std::move(bodies), trusted, actions);
  return join(bodies);
}

}  // namespace carillon::solvers::mesh::repair
