#include "solvers/mesh/repair/repair.hpp"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "solvers/mesh/repair/detail/intersections.hpp"
#include "solvers/mesh/repair/detail/pieces.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

/// Gaps of this fraction of the box diagonal are cracks between vertices meant to be one.
constexpr double crack = 1e-6;
/// More intersections than this inside one piece are no local fault.
constexpr std::size_t local_pairs = 500;
/// Change of volume that mending local intersections may cost.
constexpr double local_volume_change = 0.02;
/// Change of volume beyond which a wrap is another body.
constexpr double wrap_volume_change = 0.2;
/// Share of open edges from which triangles are a loose heap rather than a surface.
constexpr double loose_edges = 0.25;
/// Triangles in a piece, on average, from which such a heap is a sheet.
constexpr std::size_t sheet_triangles = 4;
/// A wrap with so much more area than the triangles has wrapped both of their sides.
constexpr double coat_area = 1.5;
/// Alpha of the wraps that are tried, in offsets: fine ones keep hollows, coarse ones close gaps.
constexpr double alphas[] = {5, 10, 20};
/// Parts of the offset asked for that are tried where that wraps gaps or walls away.
constexpr double finer[] = {1, 0.4};
/// Share of a surface's sides that a wrap may misplace before it is another body, and of the
/// surface where it is a gap that was closed or a wall that was lost.
constexpr double wrap_misplaced = 0.03, wrap_facing = 0.003;

/// The state of one repair.
struct Repair {
  const MeshFile& file;
  const Diagnosis& diagnosis;
  RepairReport& report;
  double diagonal = 0;
  bool trusted = true;                       ///< most triangles agreed on their orientation
  std::optional<double> volume_before = {};  ///< the input's, when it was closed
  std::optional<double> volume = {};         ///< meant by the surface, once it is closed
  bool overlapping = false;                  ///< pieces meet, so `volume` counts some space twice

  void say(std::string action) const { report.actions.push_back(std::move(action)); }
  void say(std::int64_t count, const char* format) const {
    if (count > 0) say(fmt::format(fmt::runtime(format), count));
  }
};

/// What is wrong, in words.
std::string symptoms(const Diagnosis& d) {
  std::vector<std::string> words;
  const auto add = [&words](std::int64_t count, const char* what) {
    if (count > 0) words.push_back(fmt::format("{} {}", count, what));
  };
  add(d.boundary_edges, "open edges");
  add(d.nonmanifold_edges, "edges of more than two triangles");
  add(d.nonmanifold_vertices, "vertices where surfaces only touch");
  add(d.misoriented_edges, "edges whose triangles disagree on the outside");
  add(d.degenerate_triangles, "triangles without area");
  add(d.self_intersections, "intersecting pairs of triangles");
  return words.empty() ? "nothing else is wrong with it"
                       : fmt::format("{}", fmt::join(words, ", "));
}

[[noreturn]] void refuse(const Repair& repair, const std::string& reason, const std::string& hint) {
  throw core::InputError(
      fmt::format("{}: {} ({})", repair.file.path, reason, symptoms(repair.diagnosis)), hint);
}

const char* const sheet_hint =
    "if it is meant as a sheet, say thickness: 0.003 m; otherwise close it in a modeller";

struct OpenEdges {
  std::int64_t open = 0, all = 0;
};

OpenEdges count_open(const SurfaceMesh& mesh) {
  OpenEdges count;
  for_each_edge(edge_uses(mesh.triangles), [&count](std::span<const EdgeUse> edge) {
    ++count.all;
    count.open += edge.size() == 1;
  });
  return count;
}

/// Every edge is walked as often forward as backward: closed bodies that share edges.
bool bounds_a_sum(const std::vector<Triangle>& triangles) {
  bool balanced = true;
  for_each_edge(edge_uses(triangles), [&balanced](std::span<const EdgeUse> edge) {
    const auto forward =
        std::count_if(edge.begin(), edge.end(), [](const EdgeUse& use) { return use.forward; });
    balanced = balanced && 2 * forward == static_cast<std::ptrdiff_t>(edge.size());
  });
  return balanced;
}

/// Steps that only drop or merge what is there twice or is nothing.
void tidy(SurfaceMesh& mesh, Repair& repair) {
  repair.say(weld(mesh), "merged {} vertices at the same place");
  repair.say(drop_collapsed(mesh), "dropped {} triangles that name a vertex twice");
  repair.say(drop_twins(mesh), "dropped {} double triangles");
  if (count_open(mesh).open > 0) {
    const std::int64_t merged = weld_borders(mesh, crack * repair.diagonal);
    repair.say(merged, "closed cracks by merging {} vertices");
    drop_collapsed(mesh);
    drop_twins(mesh);
  }
  repair.say(drop_unreferenced(mesh), "dropped {} vertices without triangles");
  const std::int64_t turned = orient_neighbours(mesh);
  repair.say(turned, "turned {} triangles over");
  repair.trusted = turned * 10 <= static_cast<std::int64_t>(mesh.triangles.size());
}

/// A result counts only when it is what was promised.
std::optional<SurfaceMesh> verified(SurfaceMesh mesh) {
  drop_unreferenced(mesh);
  if (!diagnose(mesh).clean) return {};
  return mesh;
}

/// Cuts, stitches, and fills what the cutting has opened.
std::optional<SurfaceMesh> closed_manifold(const SurfaceMesh& mesh, Repair& repair) {
  ManifoldChanges changes;
  SurfaceMesh apart = mesh;
  const bool cut = cut_apart(apart) > 0;
  auto manifold = make_manifold(apart, changes);
  if (!manifold) return {};
  if (cut || changes.cut) repair.say("cut edges and vertices apart where surfaces only touch");
  repair.say(changes.degenerate, "removed {} triangles without area");
  const HoleLimits limits{repair.diagonal, area(*manifold), false};
  const HoleCount holes = fill_holes(*manifold, limits);
  repair.say(holes.filled, "filled {} holes left by cutting");
  repair.say(drop_debris(*manifold), "dropped {} loose scraps");
  if (manifold->triangles.empty() || !is_closed_and_oriented(manifold->triangles)) return {};
  return manifold;
}

/// Mends intersections inside pieces; those between pieces are left to resolve_pieces().
std::optional<SurfaceMesh> without_local_intersections(SurfaceMesh mesh, Repair& repair) {
  const auto component = edge_components(mesh.triangles);
  const auto pairs = intersecting_pairs(mesh, 100 * local_pairs);
  std::vector<std::size_t> own_pairs(
      1 + static_cast<std::size_t>(*std::max_element(component.begin(), component.end())));
  for (const auto& [s, t] : pairs) {
    if (component[s] == component[t]) ++own_pairs[static_cast<std::size_t>(component[s])];
  }
  if (std::none_of(own_pairs.begin(), own_pairs.end(), [](auto n) { return n > 0; })) return mesh;
  auto pieces = split(mesh, component);
  std::size_t mended = 0;
  for (std::size_t c = 0; c < pieces.size(); ++c) {
    if (own_pairs[c] == 0) continue;
    if (own_pairs[c] > local_pairs) return {};
    auto clean = remove_self_intersections(pieces[c]);
    if (!clean || !is_closed_and_oriented(clean->triangles)) return {};
    const double before = signed_volume(pieces[c]);
    if (std::abs(signed_volume(*clean) - before) > local_volume_change * std::abs(before))
      return {};
    mended += own_pairs[c];
    pieces[c] = std::move(*clean);
  }
  repair.say(fmt::format("mended {} intersecting pairs of triangles", mended));
  return join(pieces);
}

/// The way without a wrap: closed pieces in, a body out.
std::optional<SurfaceMesh> mend(const SurfaceMesh& mesh, Repair& repair) {
  auto closed = closed_manifold(mesh, repair);
  if (!closed) return {};
  repair.overlapping = diagnose(*closed).touching_components > 0;
  repair.volume = nested_volume(*closed);
  auto local = without_local_intersections(std::move(*closed), repair);
  if (!local) return {};
  if (auto body = resolve_pieces(*local, repair.trusted, repair.report)) {
    if (auto good = verified(std::move(*body))) return good;
  }
  if (!held_together(*local)) {
    refuse(repair, "bodies touch in an edge or a point alone, where nothing holds them together",
           "bodies that belong together must share a face or overlap; others need a gap");
  }
  return {};
}

/// A sheet with the thickness that was asked for: offset if that works, else wrapped.
SurfaceMesh thickened(const SurfaceMesh& sheet, Repair& repair) {
  const double thickness = repair.file.thickness;
  ManifoldChanges changes;
  const RepairReport so_far = repair.report;
  if (auto manifold = make_manifold(sheet, changes)) {
    std::vector<SurfaceMesh> pieces = split(*manifold, edge_components(manifold->triangles));
    for (SurfaceMesh& piece : pieces) {
      if (!is_closed_and_oriented(piece.triangles)) piece = thicken(piece, thickness);
    }
    repair.say(fmt::format("gave open sheets a thickness of {:.6g} m", thickness));
    if (auto body = resolve_pieces(join(pieces), repair.trusted, repair.report)) {
      if (auto good = verified(std::move(*body))) return std::move(*good);
    }
  }
  repair.report = so_far;
  const double alpha = std::max(thickness, 0.01 * repair.diagonal);
  SurfaceMesh wrap = alpha_wrap(sheet, alpha, thickness / 2);
  const double expected = area(sheet) * thickness;
  const double volume = signed_volume(wrap);
  auto good = verified(std::move(wrap));
  if (!good || volume > 2 * expected) {
    refuse(repair, fmt::format("the sheet cannot be given a thickness of {:.6g} m", thickness),
           "a thickness that fits the sheet's folds and gaps helps, or a model with both sides");
  }
  repair.say(fmt::format("wrapped open sheets at half of the thickness of {:.6g} m", thickness));
  return std::move(*good);
}

/// The last way: wrap the triangles and pull the wrap back onto them.
SurfaceMesh wrapped(const SurfaceMesh& mesh, Repair& repair) {
  const OpenEdges edges = count_open(mesh);
  if (static_cast<double>(edges.open) > loose_edges * static_cast<double>(edges.all)) {
    const auto component = edge_components(mesh.triangles);
    const auto pieces =
        static_cast<std::size_t>(1 + *std::max_element(component.begin(), component.end()));
    if (sheet_triangles * pieces > mesh.triangles.size())
      refuse(repair,
             fmt::format("the triangles are loose and bound no body: {} of {} edges are open",
                         edges.open, edges.all),
             "export the object as one connected surface");
    refuse(repair, "the surface is a sheet and bounds no body", sheet_hint);
  }
  const double given_area = area(mesh);
  double change = 0;
  Misplaced misplaced;
  const auto is_another_body = [&misplaced] {
    return misplaced.share > wrap_misplaced || misplaced.facing > wrap_facing;
  };
  for (const double part : finer) {
    const double offset = part * repair.file.wrap_tolerance * repair.diagonal;
    for (const double multiple : alphas) {
      const SurfaceMesh coarse = alpha_wrap(mesh, multiple * offset, offset);
      if (edges.open > 0 && area(coarse) > coat_area * given_area) continue;
      auto body = verified(shrink_onto(coarse, mesh));
      if (!body) continue;
      misplaced = misplaced_points(mesh, *body, offset, multiple * offset);
      if (is_another_body()) break;  // a coarser one closes more
      if (repair.volume) {
        change = signed_volume(*body) / *repair.volume - 1;
        const bool too_small = change < -wrap_volume_change && !repair.overlapping;
        if (too_small || change > wrap_volume_change) continue;
      }
      repair.say(
          fmt::format("wrapped (alpha {:.3g} m, offset {:.3g} m) and drew the wrap onto the "
                      "triangles",
                      multiple * offset, offset));
      repair.report.wrap_alpha = multiple * offset;
      return std::move(*body);
    }
    if (!is_another_body()) break;  // a finer one would not help
  }
  const char* const hint = edges.open > 0 ? sheet_hint
                                          : "mend it in a modeller; a smaller wrap_tolerance of a "
                                            "configuration's object may keep thin walls and gaps";
  if (is_another_body()) {
    const std::string width =
        misplaced.width > 0 ? fmt::format(" of {:.2g} mm", 1e3 * misplaced.width) : "";
    refuse(repair,
           fmt::format("a wrap would close gaps or lose walls{}: {:.2g} % of the surface would not "
                       "be one any more",
                       width, 100 * std::max(misplaced.share, misplaced.facing)),
           hint);
  }
  if (std::abs(change) > wrap_volume_change) {
    refuse(repair, fmt::format("a wrap would change the volume by {:+.0f} %", 100 * change), hint);
  }
  if (edges.open > 0) refuse(repair, "the surface is open and bounds no body", sheet_hint);
  refuse(repair, "the surface cannot be repaired, nor wrapped by a body like it",
         "mend it in a modeller, or try another wrap_tolerance of a configuration's object");
}

void refuse_flat(const SurfaceMesh& mesh, const Repair& repair) {
  const Vec3 extent = bounding_box(mesh.vertices).extent();
  if (!std::isfinite(repair.diagonal) || !(area(mesh) > 0)) {
    refuse(repair, "the triangles have no area", "");
  }
  if (extent.minCoeff() < 1e-9 * repair.diagonal && !(repair.file.thickness > 0)) {
    refuse(repair, "the surface is flat and bounds no body", sheet_hint);
  }
}

SurfaceMesh treat(SurfaceMesh work, Repair& repair) {
  refuse_flat(work, repair);
  tidy(work, repair);
  if (work.triangles.empty()) refuse(repair, "the triangles have no area", "");
  if (is_closed_and_oriented(work.triangles)) {
    repair.overlapping = repair.diagnosis.touching_components > 0;
    repair.volume = nested_volume(work);
    if (!repair.volume_before) repair.volume_before = repair.volume;
  } else if (bounds_a_sum(work.triangles) && !repair.volume_before) {
    repair.volume_before = std::abs(signed_volume(work));
  }

  const bool sheet_wanted = repair.file.thickness > 0;
  const HoleCount holes = fill_holes(work, {repair.diagonal, area(work), sheet_wanted});
  repair.say(holes.filled, "filled {} holes");
  repair.report.filled_area = holes.area / area(work);
  repair.say(drop_debris(work), "dropped {} loose scraps");
  if (count_open(work).open > 0) {
    if (sheet_wanted) return thickened(work, repair);
    return wrapped(work, repair);
  }
  repair.say(drop_inner_walls(work), "dropped {} triangles of walls inside of the solid");
  const RepairReport so_far = repair.report;
  if (auto body = mend(work, repair)) return std::move(*body);
  repair.report = so_far;
  return wrapped(work, repair);
}

}  // namespace

SurfaceMesh repair(const SurfaceMesh& mesh, const MeshFile& file, Diagnosis& diagnosis,
                   RepairReport& report) {
  diagnosis = diagnose(mesh);
  report = {};
  if (diagnosis.clean) return mesh;

  if (!(file.wrap_tolerance >= 1e-4 && file.wrap_tolerance <= 0.05)) {
    throw core::InputError(
        fmt::format("{}: wrap tolerance {:.6g}; a fraction of the box diagonal from "
                    "0.0001 to 0.05 expected",
                    file.path, file.wrap_tolerance));
  }
  if (!(file.thickness >= 0) || !std::isfinite(file.thickness)) {
    throw core::InputError(fmt::format("{}: thickness {:.6g} m; a positive number expected",
                                       file.path, file.thickness));
  }
  report.used_as_is = false;
  Repair repair{file, diagnosis, report, bounding_box(mesh.vertices).extent().norm()};
  if (diagnosis.closed && diagnosis.misoriented_edges == 0) {
    repair.volume_before = std::abs(diagnosis.volume);
  }
  SurfaceMesh body = treat(mesh, repair);
  const auto pieces = split(body, edge_components(body.triangles));
  if (pieces.size() > 1) {
    repair.say(fmt::format("the object consists of {} closed surfaces", pieces.size()));
  }
  // Where pieces meet, or lie in what is solid already, their sum was no body's volume.
  const bool counts_twice = repair.overlapping || report.swallowed_surfaces > 0;
  const double before = counts_twice ? 0 : repair.volume_before.value_or(0);
  report.volume_change =
      before > 0 ? signed_volume(body) / before - 1 : std::numeric_limits<double>::quiet_NaN();
  report.area_change = diagnosis.area > 0 ? area(body) / diagnosis.area - 1
                                          : std::numeric_limits<double>::quiet_NaN();
  return body;
}

}  // namespace carillon::solvers::mesh::repair
