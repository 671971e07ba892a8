// Steps of the repair that CGAL's polygon mesh processing does.
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/utility.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <exception>
#include <iterator>

#include "solvers/mesh/repair/detail/hole_loops.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"
#include "solvers/mesh/simplify/cgal_mesh.hpp"
#include "solvers/mesh/simplify/cgal_optional.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using simplify::CgalMesh;
using simplify::from_cgal;

/// False when the triangles are no manifold.
bool to_cgal_mesh(const SurfaceMesh& mesh, CgalMesh& out) {
  const simplify::CgalSoup soup = simplify::to_soup(mesh);
  if (!pmp::is_polygon_soup_a_polygon_mesh(soup.polygons)) return false;
  pmp::polygon_soup_to_polygon_mesh(soup.points, soup.polygons, out);
  return true;
}

/// Turns components over whose majority was turned by CGAL; `before[t]` belongs to `after[t]`.
void restore_majority(const SurfaceMesh& before, SurfaceMesh& after) {
  const auto component = edge_components(after.triangles);
  std::vector<double> agreement;
  const auto normal = [](const SurfaceMesh& mesh, std::size_t t) -> Vec3 {
    const auto p = [&](std::size_t i) {
      return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][i])];
    };
    return (p(1) - p(0)).cross(p(2) - p(0));
  };
  for (std::size_t t = 0; t < component.size(); ++t) {
    const auto c = static_cast<std::size_t>(component[t]);
    if (agreement.size() <= c) agreement.resize(c + 1, 0);
    const double dot = normal(before, t).dot(normal(after, t));
    agreement[c] += std::copysign(std::sqrt(std::abs(dot)), dot);
  }
  for (std::size_t c = 0; c < agreement.size(); ++c) {
    if (agreement[c] < 0) reverse(after, component, static_cast<std::int32_t>(c));
  }
}

}  // namespace

std::vector<Triangle> triangulate_loop(const SurfaceMesh& mesh, const HoleLoop& loop) {
  std::vector<simplify::CgalPoint> points;
  std::vector<simplify::CgalPoint> opposite;
  for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
    points.push_back(simplify::to_cgal(mesh.vertices[static_cast<std::size_t>(loop.vertices[i])]));
    opposite.push_back(
        simplify::to_cgal(mesh.vertices[static_cast<std::size_t>(loop.opposite[i])]));
  }
  std::vector<CGAL::Triple<int, int, int>> patch;
  pmp::triangulate_hole_polyline(points, opposite, std::back_inserter(patch));
  // CGAL does not promise an orientation: a patch triangle must walk its rim as the loop does.
  const auto sides = static_cast<int>(points.size());
  bool against = false;
  for (const auto& t : patch) {
    against = against || (t.first + 1) % sides == t.third || (t.second + 1) % sides == t.first ||
              (t.third + 1) % sides == t.second;
  }
  std::vector<Triangle> triangles;
  for (const auto& t : patch) {
    const auto v = [&loop](int i) { return loop.vertices[static_cast<std::size_t>(i)]; };
    triangles.push_back(
        {v(t.first), v(against ? t.third : t.second), v(against ? t.second : t.third)});
  }
  return triangles;
}

std::optional<SurfaceMesh> make_manifold(const SurfaceMesh& mesh, ManifoldChanges& changes) {
  simplify::CgalSoup soup = simplify::to_soup(mesh);
  changes.cut = !pmp::orient_polygon_soup(soup.points, soup.polygons);
  SurfaceMesh oriented = from_cgal(soup);
  restore_majority(mesh, oriented);

  CgalMesh surface;
  if (!to_cgal_mesh(oriented, surface)) return {};
  if (changes.cut) pmp::stitch_borders(surface);
  const auto before = static_cast<std::int64_t>(surface.number_of_faces());
  if (!pmp::remove_degenerate_faces(surface)) return {};
  changes.degenerate = before - static_cast<std::int64_t>(surface.number_of_faces());
  return from_cgal(surface);
}

std::optional<SurfaceMesh> remove_self_intersections(const SurfaceMesh& mesh) {
  CgalMesh surface;
  if (!to_cgal_mesh(mesh, surface)) return {};
  if (!pmp::experimental::remove_self_intersections(surface,
                                                    CGAL::parameters::preserve_genus(false))) {
    return {};
  }
  return from_cgal(surface);
}

std::optional<SurfaceMesh> unite(const std::vector<SurfaceMesh>& bodies) {
  CgalMesh whole;
  if (!to_cgal_mesh(bodies.front(), whole)) return {};
  try {
    for (std::size_t i = 1; i < bodies.size(); ++i) {
      CgalMesh next;
      CgalMesh both;
      if (!to_cgal_mesh(bodies[i], next)) return {};
      if (!pmp::corefine_and_compute_union(whole, next, both,
                                           CGAL::parameters::throw_on_self_intersection(true))) {
        return {};
      }
      // Exact intersection points are rounded to doubles, which may flatten triangles.
      if (!pmp::remove_degenerate_faces(both)) return {};
      whole = std::move(both);
    }
  } catch (const std::exception&) {
    return {};  // rounding has made an operand intersect itself, or a CGAL check failed
  }
  return from_cgal(whole);
}

std::optional<SurfaceMesh> subtract(const SurfaceMesh& body, const SurfaceMesh& hollow) {
  CgalMesh whole;
  CgalMesh inner;
  CgalMesh rest;
  if (!to_cgal_mesh(body, whole) || !to_cgal_mesh(hollow, inner)) return {};
  try {
    if (!pmp::corefine_and_compute_difference(whole, inner, rest,
                                              CGAL::parameters::throw_on_self_intersection(true)) ||
        !pmp::remove_degenerate_faces(rest)) {
      return {};
    }
  } catch (const std::exception&) {
    return {};
  }
  return from_cgal(rest);
}

bool only_touch(const SurfaceMesh& one, const SurfaceMesh& other) {
  CgalMesh a;
  CgalMesh b;
  CgalMesh both;
  CgalMesh common;
  if (!to_cgal_mesh(one, a) || !to_cgal_mesh(other, b)) return false;
  std::array<simplify::CgalOptional<CgalMesh*>, 4> wanted;
  wanted[pmp::Corefinement::UNION] = &both;
  wanted[pmp::Corefinement::INTERSECTION] = &common;
  try {
    const auto made = pmp::corefine_and_compute_boolean_operations(
        a, b, wanted, CGAL::parameters::throw_on_self_intersection(true));
    if (!made[pmp::Corefinement::INTERSECTION] || common.number_of_faces() > 0) return false;
    // Bodies that share a face become one.
    if (!made[pmp::Corefinement::UNION]) return true;
    const auto component = edge_components(from_cgal(both).triangles);
    return std::any_of(component.begin(), component.end(), [](auto c) { return c > 0; });
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace carillon::solvers::mesh::repair
