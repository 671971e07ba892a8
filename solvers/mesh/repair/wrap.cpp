#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/polygon_mesh_to_polygon_soup.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>

#include "solvers/mesh/repair/detail/intersections.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/repair/detail/surface_topology.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
using Tree = CGAL::AABB_tree<
    CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>>>;

Point to_point(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}

/// Share of the way to the surface that a wrap's vertex goes at first; not the whole, so that
/// vertices which would meet on an edge of the surface stay apart.
constexpr double kFirstShare = 0.98;
/// Halvings of the share where triangles intersect; after them it is zero.
constexpr int kHalvings = 8;

}  // namespace

SurfaceMesh alpha_wrap(const SurfaceMesh& soup, double alpha, double offset) {
  std::vector<Point> points;
  for (const Vec3& v : soup.vertices) points.push_back(to_point(v));
  std::vector<std::vector<std::size_t>> polygons;
  for (const Triangle& t : soup.triangles) {
    polygons.push_back({static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                        static_cast<std::size_t>(t[2])});
  }
  CGAL::Surface_mesh<Point> wrap;
  CGAL::alpha_wrap_3(points, polygons, alpha, offset, wrap);

  std::vector<Point> wrap_points;
  std::vector<std::vector<std::size_t>> wrap_triangles;
  CGAL::Polygon_mesh_processing::polygon_mesh_to_polygon_soup(wrap, wrap_points, wrap_triangles);
  SurfaceMesh mesh;
  for (const Point& p : wrap_points) mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  for (const auto& t : wrap_triangles) {
    mesh.triangles.push_back({static_cast<std::int32_t>(t[0]), static_cast<std::int32_t>(t[1]),
                              static_cast<std::int32_t>(t[2])});
  }
  return mesh;
}

SurfaceMesh shrink_onto(const SurfaceMesh& wrap, const SurfaceMesh& soup) {
  Triangles triangles;
  for (const Triangle& t : soup.triangles) {
    const auto p = [&](std::size_t i) {
      return to_point(soup.vertices[static_cast<std::size_t>(t[i])]);
    };
    const Kernel::Triangle_3 triangle(p(0), p(1), p(2));
    if (!triangle.is_degenerate()) triangles.push_back(triangle);
  }
  const Tree tree(triangles.cbegin(), triangles.cend());
  std::vector<Vec3> target;
  for (const Vec3& v : wrap.vertices) {
    const Point p = tree.closest_point(to_point(v));
    target.emplace_back(p.x(), p.y(), p.z());
  }

  std::vector<double> share(wrap.vertices.size(), kFirstShare);
  SurfaceMesh shrunk = wrap;
  for (int round = 0; round <= kHalvings; ++round) {
    for (std::size_t v = 0; v < share.size(); ++v) {
      shrunk.vertices[v] = wrap.vertices[v] + share[v] * (target[v] - wrap.vertices[v]);
    }
    std::vector<bool> bad(share.size(), false);
    const auto mark = [&](std::size_t t) {
      for (const std::int32_t v : shrunk.triangles[t]) bad[static_cast<std::size_t>(v)] = true;
    };
    for (const auto& [s, t] : intersecting_pairs(shrunk, shrunk.triangles.size() * 10)) {
      mark(s);
      mark(t);
    }
    for (const std::size_t t : degenerate_triangles(shrunk)) mark(t);
    if (std::none_of(bad.begin(), bad.end(), [](bool b) { return b; })) return shrunk;
    // Neighbours follow, so that the way back has no steps.
    std::vector<bool> relax = bad;
    for (const Triangle& t : shrunk.triangles) {
      const bool near = std::any_of(
          t.begin(), t.end(), [&bad](std::int32_t v) { return bad[static_cast<std::size_t>(v)]; });
      for (const std::int32_t v : t) {
        if (near) relax[static_cast<std::size_t>(v)] = true;
      }
    }
    for (std::size_t v = 0; v < share.size(); ++v) {
      if (relax[v]) share[v] = round + 2 > kHalvings ? 0 : share[v] / 2;
    }
  }
  return wrap;
}

}  // namespace carillon::solvers::mesh::repair
