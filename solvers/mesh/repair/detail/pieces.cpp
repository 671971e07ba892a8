#include "solvers/mesh/repair/detail/pieces.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "core/disjoint_sets.hpp"
#include "solvers/mesh/repair/detail/intersections.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

/// Enough to find every pair of pieces that meet in all but absurd input.
constexpr std::size_t piece_pair_limit = 1000000;
/// More pieces than this are a body's decomposition into convex ones; of those so much of the
/// volume may touch the rest alone.
constexpr std::size_t many_pieces = 16;
constexpr double loose_share = 0.25;
/// Faces this near to each other, as a part of the diagonal, are meant to meet when they are more
/// than this part of a piece's surface: rounding parts what a decomposition has cut.
constexpr double contact_gap = 1e-3, contact_area = 0.02;

void turn_over(SurfaceMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

using Meetings = std::set<std::pair<std::size_t, std::size_t>>;

/// Pairs of pieces that meet; nothing when a piece meets itself.
std::optional<Meetings> find_meetings(const SurfaceMesh& mesh,
                                      const std::vector<std::int32_t>& component) {
  Meetings meetings;
  for (const auto& [s, t] : intersecting_pairs(mesh, piece_pair_limit)) {
    if (component[s] == component[t]) return {};
    meetings.insert(std::minmax(static_cast<std::size_t>(component[s]),
                                static_cast<std::size_t>(component[t])));
  }
  return meetings;
}

std::vector<std::vector<std::size_t>> groups(const Meetings& meetings, std::size_t pieces) {
  core::DisjointSets meeting(pieces);
  for (const auto& [a, b] : meetings) meeting.join(a, b);
  std::map<std::size_t, std::vector<std::size_t>> members;
  for (std::size_t i = 0; i < pieces; ++i) members[meeting.find(i)].push_back(i);
  std::vector<std::vector<std::size_t>> all;
  for (auto& entry : members) all.push_back(std::move(entry.second));
  return all;
}

/// Turns pieces so that they bound material, and leaves out those inside of it.
std::vector<SurfaceMesh> settle_nesting(std::vector<SurfaceMesh> pieces, bool trusted,
                                        RepairReport& report) {
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
      // As nested hollows and cores would be: by the depth below what is kept.
      std::size_t depth = 0;
      for (const std::size_t outer : around[i]) depth += !kept[outer];
      const double own = std::abs(signed_volume(pieces[i]));
      report.swallowed_volume += depth % 2 == 0 ? own : -own;
      continue;
    }
    turned += outward[i] != wanted;
    if (outward[i] != wanted) turn_over(pieces[i]);
    outward[i] = wanted;
    cavities += !wanted;
  }
  if (turned > 0) report.actions.push_back(fmt::format("turned {} closed piece(s) over", turned));
  if (cavities > 0)
    report.actions.push_back(fmt::format("kept {} inner piece(s) as cavities", cavities));
  report.swallowed_surfaces += swallowed;
  if (swallowed > 0) {
    report.actions.push_back(
        fmt::format("removed {} piece(s) that lay inside the material", swallowed));
  }
  std::vector<SurfaceMesh> result;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (kept[i]) result.push_back(std::move(pieces[i]));
  }
  return result;
}

/// Whether an inward piece that meets a body is a cavity of it: most of what it bounds is the
/// body's; else it is a body that was read inside out.
std::optional<SurfaceMesh> without_cavity(const SurfaceMesh& body, const SurfaceMesh& cavity) {
  auto rest = subtract(body, cavity);
  if (!rest || rest->triangles.empty()) return {};
  const double taken = signed_volume(body) - signed_volume(*rest);
  if (taken < 0.5 * signed_volume(cavity)) return {};
  return rest;
}

/// What pieces that meet bound together: outward ones are united, inward ones taken out of them.
std::optional<SurfaceMesh> one_body(std::vector<SurfaceMesh> pieces, bool trusted,
                                    RepairReport& report) {
  const auto largest =
      std::max_element(pieces.begin(), pieces.end(), [](const auto& a, const auto& b) {
        return std::abs(signed_volume(a)) < std::abs(signed_volume(b));
      });
  const bool inside_out = signed_volume(*largest) < 0;
  std::vector<SurfaceMesh> outward, inward;
  for (SurfaceMesh& piece : pieces) {
    const bool cavity = trusted && (signed_volume(piece) < 0) != inside_out;
    if (signed_volume(piece) < 0) turn_over(piece);
    (cavity ? inward : outward).push_back(std::move(piece));
  }
  const auto united = [&report](const std::vector<SurfaceMesh>& bodies) {
    auto both = unite(bodies);
    if (both && bodies.size() > 1)
      report.actions.push_back(fmt::format("united {} pieces that meet", bodies.size()));
    return both;
  };
  auto body = united(outward);
  std::size_t cavities = 0;
  std::vector<SurfaceMesh> misread;
  for (SurfaceMesh& piece : inward) {
    if (!body) break;
    if (auto rest = without_cavity(*body, piece)) {
      body = std::move(rest);
      ++cavities;
    } else {
      misread.push_back(std::move(piece));
    }
  }
  if (cavities > 0)
    report.actions.push_back(
        fmt::format("took {} inward piece(s) as cavities out of what they meet", cavities));
  if (body && !misread.empty()) {
    misread.insert(misread.begin(), std::move(*body));
    body = united(misread);
  }
  return body;
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
                                          RepairReport& report) {
  const auto component = edge_components(mesh.triangles);
  std::vector<SurfaceMesh> pieces = split(mesh, component);
  const auto meetings = find_meetings(mesh, component);
  if (!meetings) return {};

  std::vector<SurfaceMesh> bodies;
  for (const auto& group : groups(*meetings, pieces.size())) {
    if (group.size() == 1) {
      bodies.push_back(std::move(pieces[group[0]]));
      continue;
    }
    std::vector<SurfaceMesh> members;
    for (const std::size_t i : group) members.push_back(std::move(pieces[i]));
    auto both = one_body(std::move(members), trusted, report);
    if (!both) return {};
    for (SurfaceMesh& part : split(*both, edge_components(both->triangles))) {
      bodies.push_back(std::move(part));
    }
  }
  bodies = settle_nesting(std::move(bodies), trusted, report);
  return join(bodies);
}

bool held_together(const SurfaceMesh& mesh) {
  const auto component = edge_components(mesh.triangles);
  std::vector<SurfaceMesh> pieces = split(mesh, component);
  auto meetings = find_meetings(mesh, component);
  if (!meetings) return true;
  for (SurfaceMesh& piece : pieces) {
    if (signed_volume(piece) < 0) turn_over(piece);
  }
  const auto volume = [&pieces](const std::vector<std::size_t>& group) {
    double sum = 0;
    for (const std::size_t i : group) sum += signed_volume(pieces[i]);
    return sum;
  };
  const auto met = groups(*meetings, pieces.size());
  const double reach = contact_gap * bounding_box(mesh.vertices).extent().norm();
  std::erase_if(*meetings, [&](const auto& pair) {
    const SurfaceMesh& a = pieces[pair.first];
    const SurfaceMesh& b = pieces[pair.second];
    return only_touch(a, b) && facing_share(a, b, reach) < contact_area &&
           facing_share(b, a, reach) < contact_area;
  });
  const auto held = groups(*meetings, pieces.size());
  if (pieces.size() <= many_pieces) return held.size() == met.size();
  double loose = 0, all = 0;
  for (const auto& group : met) {
    double largest = 0;
    for (const auto& part : held) {
      if (std::find(group.begin(), group.end(), part.front()) != group.end())
        largest = std::max(largest, volume(part));
    }
    loose += volume(group) - largest;
    all += volume(group);
  }
  return loose < loose_share * all;
}

}  // namespace carillon::solvers::mesh::repair
