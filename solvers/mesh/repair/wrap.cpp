#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "core/numbers.hpp"
#include "solvers/mesh/repair/detail/intersections.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/simplify/cgal_mesh.hpp"
#include "solvers/mesh/simplify/cgal_trees.hpp"
#include "solvers/mesh/spread_points.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

using Kernel = simplify::CgalKernel;
using simplify::to_cgal;
using Triangles = simplify::CgalTriangles<Kernel>;
using Tree = simplify::CgalTriangleTree<Kernel>;

/// Cosine from which triangles face each other.
constexpr double facing = 0.7;

/// Share of the way to the surface that a wrap's vertex goes at first; not the whole, so that
/// vertices which would meet on an edge of the surface stay apart.
constexpr double first_fraction = 0.98;
/// Halvings of the fraction where triangles intersect; after them it is zero.
constexpr int halvings = 8;

Triangles sound_triangles(const SurfaceMesh& soup) {
  Triangles triangles;
  for (const Triangle& t : soup.triangles) {
    const auto p = [&](std::size_t i) {
      return to_cgal(soup.vertices[static_cast<std::size_t>(t[i])]);
    };
    const Kernel::Triangle_3 triangle(p(0), p(1), p(2));
    if (!triangle.is_degenerate()) triangles.push_back(triangle);
  }
  return triangles;
}

/// Unit normal of a triangle.
Vec3 normal_of(const SurfaceMesh& mesh, std::size_t t) {
  const auto corner = [&](std::size_t i) -> const Vec3& {
    return mesh.vertices[static_cast<std::size_t>(mesh.triangles[t][i])];
  };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
}

Vec3 normal_of(const Kernel::Triangle_3& triangle) {
  const Vec3 a = simplify::from_cgal(triangle.vertex(0)),
             b = simplify::from_cgal(triangle.vertex(1)),
             c = simplify::from_cgal(triangle.vertex(2));
  return (b - a).cross(c - a).normalized();
}

}  // namespace

SurfaceMesh alpha_wrap(const SurfaceMesh& soup, double alpha, double offset) {
  const simplify::CgalSoup cgal = simplify::to_soup(soup);
  simplify::CgalMesh wrap;
  CGAL::alpha_wrap_3(cgal.points, cgal.polygons, alpha, offset, wrap);
  return simplify::from_cgal(wrap);
}

SurfaceMesh shrink_onto(const SurfaceMesh& wrap, const SurfaceMesh& soup) {
  const Triangles triangles = sound_triangles(soup);
  const Tree tree(triangles.cbegin(), triangles.cend());
  std::vector<Vec3> target;
  for (const Vec3& v : wrap.vertices) {
    target.push_back(simplify::from_cgal(tree.closest_point(to_cgal(v))));
  }

  std::vector<double> fraction(wrap.vertices.size(), first_fraction);
  SurfaceMesh shrunk = wrap;
  for (int round = 0; round <= halvings; ++round) {
    for (std::size_t v = 0; v < fraction.size(); ++v) {
      shrunk.vertices[v] = wrap.vertices[v] + fraction[v] * (target[v] - wrap.vertices[v]);
    }
    std::vector<bool> bad(fraction.size(), false);
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
    for (std::size_t v = 0; v < fraction.size(); ++v) {
      if (relax[v]) fraction[v] = round + 2 > halvings ? 0 : fraction[v] / 2;
    }
  }
  return wrap;
}

Misplaced misplaced_points(const SurfaceMesh& soup, const SurfaceMesh& body, double extent,
                           double alpha) {
  constexpr std::size_t count = 2000;
  const Triangles triangles = sound_triangles(soup);
  const Tree tree(triangles.cbegin(), triangles.cend());
  const simplify::CgalMesh closed = simplify::closed_cgal_mesh(body);
  const CGAL::Side_of_triangle_mesh<simplify::CgalMesh, Kernel> side_of(closed);
  std::size_t wrong = 0;
  std::vector<double> widths;
  const std::vector<SpreadPoint> points = spread_points(soup, count);
  for (const auto& [point, triangle] : points) {
    const Vec3 normal = normal_of(soup, triangle);
    for (const double side : {1.0, -1.0}) {
      // The ray begins beside its own triangle.
      const Vec3 way = side * normal, from = point + 1e-3 * extent * way;
      double free = 2 * extent, gap = 0;
      if (const auto hit =
              tree.first_intersection(Kernel::Ray_3(to_cgal(from), to_cgal(Vec3(from + way))))) {
        if (const auto* met = simplify::held<Kernel::Point_3>(hit->first)) {
          const double distance = (simplify::from_cgal(*met) - point).norm();
          if (distance < alpha + free && normal_of(*hit->second).dot(normal) < -facing)
            gap = distance;
          free = std::min(free, distance);
        }
      }
      const Vec3 beside = point + free / 2 * way;
      const bool is_inside = side_of(to_cgal(beside)) == CGAL::ON_BOUNDED_SIDE;
      // Most triangles look outward; only what contradicts them is worth the winding number.
      if (is_inside == (side < 0)) continue;
      if (is_inside == (std::abs(winding_number(soup, beside)) > 0.5)) continue;
      ++wrong;
      if (gap > 0) widths.push_back(gap);
    }
  }
  const auto all = static_cast<double>(points.size());
  return {static_cast<double>(wrong) / (2 * all), static_cast<double>(widths.size()) / all,
          widths.empty() ? 0 : core::median(widths)};
}

double facing_share(const SurfaceMesh& one, const SurfaceMesh& other, double reach) {
  constexpr std::size_t count = 300;
  const Triangles triangles = sound_triangles(other);
  const Tree tree(triangles.cbegin(), triangles.cend());
  std::size_t faced = 0;
  const std::vector<SpreadPoint> points = spread_points(one, count);
  for (const auto& [point, triangle] : points) {
    const Vec3 normal = normal_of(one, triangle);
    const Kernel::Segment_3 around(to_cgal(Vec3(point - reach * normal)),
                                   to_cgal(Vec3(point + reach * normal)));
    faced += tree.do_intersect(around);
  }
  return static_cast<double>(faced) / static_cast<double>(points.size());
}

}  // namespace carillon::solvers::mesh::repair
