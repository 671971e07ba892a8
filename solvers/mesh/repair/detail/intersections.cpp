#include "solvers/mesh/repair/detail/intersections.hpp"

#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <array>

#include "solvers/mesh/simplify/cgal_mesh.hpp"

namespace carillon::solvers::mesh::repair {
namespace {

using Kernel = simplify::CgalKernel;
using Point = simplify::CgalPoint;
using IndexedBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::size_t>;

/// Thrown to leave CGAL's box loop once enough pairs are known.
struct Enough {};

class PairTest {
 public:
  explicit PairTest(const SurfaceMesh& mesh) : mesh_(mesh) {
    points_.reserve(mesh.vertices.size());
    for (const Vec3& v : mesh.vertices) points_.push_back(simplify::to_cgal(v));
  }

  bool degenerate(std::size_t t) const {
    const Triangle& tri = mesh_.triangles[t];
    return CGAL::collinear(point(tri[0]), point(tri[1]), point(tri[2]));
  }

  bool intersect(std::size_t s, std::size_t t) const {
    const Triangle& a = mesh_.triangles[s];
    const Triangle& b = mesh_.triangles[t];
    int shared = 0;
    std::size_t at_a = 0;
    std::size_t at_b = 0;
    std::array<bool, 3> in_b{};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto found = std::find(b.begin(), b.end(), a[i]);
      if (found == b.end()) continue;
      in_b[i] = true;
      ++shared;
      at_a = i;
      at_b = static_cast<std::size_t>(found - b.begin());
    }
    if (shared == 3) return false;
    if (shared == 2) return fold(a, b, in_b);
    if (shared == 1) {
      return CGAL::do_intersect(triangle(a), segment(b, at_b)) ||
             CGAL::do_intersect(triangle(b), segment(a, at_a));
    }
    return CGAL::do_intersect(triangle(a), triangle(b));
  }

  CGAL::Bbox_3 box(std::size_t t) const { return triangle(mesh_.triangles[t]).bbox(); }

 private:
  const Point& point(std::int32_t v) const { return points_[static_cast<std::size_t>(v)]; }
  Kernel::Triangle_3 triangle(const Triangle& t) const {
    return {point(t[0]), point(t[1]), point(t[2])};
  }
  /// The side opposite to corner i.
  Kernel::Segment_3 segment(const Triangle& t, std::size_t i) const {
    return {point(t[(i + 1) % 3]), point(t[(i + 2) % 3])};
  }
  /// Triangles that share an edge overlap when they lie in one plane on the same side of it.
  bool fold(const Triangle& a, const Triangle& b, const std::array<bool, 3>& in_b) const {
    const auto own =
        static_cast<std::size_t>(std::find(in_b.begin(), in_b.end(), false) - in_b.begin());
    const Point& p = point(a[(own + 1) % 3]);
    const Point& q = point(a[(own + 2) % 3]);
    const Point& r = point(a[own]);
    const auto other = std::find_if(b.begin(), b.end(), [&](std::int32_t v) {
      return v != a[(own + 1) % 3] && v != a[(own + 2) % 3];
    });
    const Point& s = point(*other);
    return CGAL::coplanar(p, q, r, s) && CGAL::coplanar_orientation(p, q, r, s) == CGAL::POSITIVE;
  }

  const SurfaceMesh& mesh_;
  std::vector<Point> points_;
};

}  // namespace

std::vector<std::size_t> degenerate_triangles(const SurfaceMesh& mesh) {
  const PairTest test(mesh);
  std::vector<std::size_t> found;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (test.degenerate(t)) found.push_back(t);
  }
  return found;
}

std::vector<std::pair<std::size_t, std::size_t>> intersecting_pairs(const SurfaceMesh& mesh,
                                                                    std::size_t limit) {
  const PairTest test(mesh);
  std::vector<IndexedBox> boxes;
  boxes.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!test.degenerate(t)) boxes.emplace_back(test.box(t), t);
  }
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  try {
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(),
                                  [&](const IndexedBox& x, const IndexedBox& y) {
                                    if (!test.intersect(x.info(), y.info())) return;
                                    pairs.push_back(std::minmax(x.info(), y.info()));
                                    if (pairs.size() >= limit) throw Enough();
                                  });
  } catch (const Enough&) {
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace carillon::solvers::mesh::repair
