#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/polygon_mesh_to_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Surface_mesh.h>

#include <exception>

#include "solvers/repair_steps.hpp"

namespace carillon::solvers {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
using CgalMesh = CGAL::Surface_mesh<Point>;

CgalMesh to_cgal(const SurfaceMesh& mesh) {
  std::vector<Point> points;
  for (const Vec3& v : mesh.vertices) points.emplace_back(v.x(), v.y(), v.z());
  CgalMesh out;
  pmp::polygon_soup_to_polygon_mesh(points, mesh.triangles, out);
  return out;
}

SurfaceMesh from_cgal(const CgalMesh& mesh) {
  std::vector<Point> points;
  std::vector<std::vector<std::size_t>> triangles;
  pmp::polygon_mesh_to_polygon_soup(mesh, points, triangles);
  SurfaceMesh out;
  for (const Point& p : points) out.vertices.emplace_back(p.x(), p.y(), p.z());
  for (const auto& t : triangles) {
    out.triangles.push_back({static_cast<std::int32_t>(t[0]), static_cast<std::int32_t>(t[1]),
                             static_cast<std::int32_t>(t[2])});
  }
  return out;
}

}  // namespace

std::optional<SurfaceMesh> unite(const std::vector<SurfaceMesh>& bodies) {
  CgalMesh whole = to_cgal(bodies.front());
  try {
    for (std::size_t i = 1; i < bodies.size(); ++i) {
      CgalMesh next = to_cgal(bodies[i]);
      CgalMesh both;
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

}  // namespace carillon::solvers
