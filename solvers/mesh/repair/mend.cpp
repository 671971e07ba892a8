// Steps of the repair that CGAL's polygon mesh processing does.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_mesh_to_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/utility.h>

#include <Eigen/Geometry>
#include <exception>
#include <iterator>

#include "solvers/mesh/repair/detail/hole_loops.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using CgalMesh = CGAL::Surface_mesh<Point>;
using Polygon = std::vector<std::size_t>;

Point to_point(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

void to_soup(const SurfaceMesh& mesh, std::vector<Point>& points, std::vector<Polygon>& polygons) {
  for (const Vec3& v : mesh.vertices) points.push_back(to_point(v));
  for (const Triangle& t : mesh.triangles) {
    polygons.push_back({static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                        static_cast<std::size_t>(t[2])});
  }
}

SurfaceMesh from_soup(const std::vector<Point>& points, const std::vector<Polygon>& polygons) {
  SurfaceMesh mesh;
  for (const Point& p : points) mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  for (const Polygon& p : polygons) {
    mesh.triangles.push_back({static_cast<std::int32_t>(p[0]), static_cast<std::int32_t>(p[1]),
                              static_cast<std::int32_t>(p[2])});
  }
  return mesh;
}

/// False when the triangles are no manifold.
bool to_cgal(const SurfaceMesh& mesh, CgalMesh& out) {
  std::vector<Point> points;
  std::vector<Polygon> polygons;
  to_soup(mesh, points, polygons);
  if (!pmp::is_polygon_soup_a_polygon_mesh(polygons)) return false;
  pmp::polygon_soup_to_polygon_mesh(points, polygons, out);
  return true;
}

SurfaceMesh from_cgal(const CgalMesh& mesh) {
  std::vector<Point> points;
  std::vector<Polygon> polygons;
  pmp::polygon_mesh_to_polygon_soup(mesh, points, polygons);
  return from_soup(points, polygons);
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
  std::vector<Point> points;
  std::vector<Point> opposite;
  for (std::size_t i = 0; i < loop.vertices.size(); ++i) {
    points.push_back(to_point(mesh.vertices[static_cast<std::size_t>(loop.vertices[i])]));
    opposite.push_back(to_point(mesh.vertices[static_cast<std::size_t>(loop.opposite[i])]));
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
  std::vector<Point> points;
  std::vector<Polygon> polygons;
  to_soup(mesh, points, polygons);
  changes.cut = !pmp::orient_polygon_soup(points, polygons);
  SurfaceMesh oriented = from_soup(points, polygons);
  restore_majority(mesh, oriented);

  CgalMesh surface;
  if (!to_cgal(oriented, surface)) return {};
  if (changes.cut) pmp::stitch_borders(surface);
  const auto before = static_cast<std::int64_t>(surface.number_of_faces());
  if (!pmp::remove_degenerate_faces(surface)) return {};
  changes.degenerate = before - static_cast<std::int64_t>(surface.number_of_faces());
  return from_cgal(surface);
}

std::optional<SurfaceMesh> remove_self_intersections(const SurfaceMesh& mesh) {
  CgalMesh surface;
  if (!to_cgal(mesh, surface)) return {};
  if (!pmp::experimental::remove_self_intersections(surface,
                                                    CGAL::parameters::preserve_genus(false))) {
    return {};
  }
  return from_cgal(surface);
}

std::optional<SurfaceMesh> unite(const std::vector<SurfaceMesh>& bodies) {
  CgalMesh whole;
  if (!to_cgal(bodies.front(), whole)) return {};
  try {
    for (std::size_t i = 1; i < bodies.size(); ++i) {
      CgalMesh next;
      CgalMesh both;
      if (!to_cgal(bodies[i], next)) return {};
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

}  // namespace carillon::solvers::mesh::repair
