#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>

#include "solvers/mesh/repair/detail/intersections.hpp"
#include "solvers/mesh/repair/detail/repair_steps.hpp"
#include "solvers/mesh/simplify/cgal_mesh.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

using Kernel = simplify::CgalKernel;
using simplify::to_cgal;
using Triangles = std::vector<Kernel::Triangle_3>;
using Tree = CGAL::AABB_tree<
    CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>>>;

/// Share of the way to the surface that a wrap's vertex goes at first; not the whole, so that
/// vertices which would meet on an edge of the surface stay apart.
constexpr double first_fraction = 0.98;
/// Halvings of the fraction where triangles intersect; after them it is zero.
constexpr int halvings = 8;

}  // namespace

SurfaceMesh alpha_wrap(const SurfaceMesh& soup, double alpha, double offset) {
  const simplify::CgalSoup cgal = simplify::to_soup(soup);
  simplify::CgalMesh wrap;
  CGAL::alpha_wrap_3(cgal.points, cgal.polygons, alpha, offset, wrap);
  return simplify::from_cgal(wrap);
}

SurfaceMesh shrink_onto(const SurfaceMesh& wrap, const SurfaceMesh& soup) {
  Triangles triangles;
  for (const Triangle& t : soup.triangles) {
    const auto p = [&](std::size_t i) {
      return to_cgal(soup.vertices[static_cast<std::size_t>(t[i])]);
    };
    const Kernel::Triangle_3 triangle(p(0), p(1), p(2));
    if (!triangle.is_degenerate()) triangles.push_back(triangle);
  }
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

}  // namespace carillon::solvers::mesh::repair
