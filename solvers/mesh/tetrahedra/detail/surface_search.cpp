#include "solvers/mesh/tetrahedra/detail/surface_search.hpp"

#include <CGAL/AABB_segment_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <Eigen/Geometry>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

namespace carillon::solvers::mesh::tetrahedra {
namespace {

using Cartesian = CGAL::Simple_cartesian<double>;
using FacetList = std::vector<Cartesian::Triangle_3>;
using FacetPrimitive = CGAL::AABB_triangle_primitive<Cartesian, FacetList::const_iterator>;
using FacetTree = CGAL::AABB_tree<CGAL::AABB_traits<Cartesian, FacetPrimitive>>;
using SegmentList = std::vector<Cartesian::Segment_3>;
using SegmentPrimitive = CGAL::AABB_segment_primitive<Cartesian, SegmentList::const_iterator>;
using SegmentTree = CGAL::AABB_tree<CGAL::AABB_traits<Cartesian, SegmentPrimitive>>;

Cartesian::Point_3 facet_point(const Vec3& p) {
  return {p.x(), p.y(), p.z()};
}
Vec3 coordinates(const Cartesian::Point_3& p) {
  return {p.x(), p.y(), p.z()};
}

Vec3 normal_of(const Cartesian::Triangle_3& facet) {
  const Vec3 a = coordinates(facet[0]);
  return (coordinates(facet[1]) - a).cross(coordinates(facet[2]) - a).normalized();
}

/// Signed way along `direction` (unit length) from a point to the plane of a facet.
double way_to(const Cartesian::Triangle_3& facet, const Vec3& facing, const Vec3& point,
              const Vec3& direction) {
  return facing.dot(coordinates(facet[0]) - point) / facing.dot(direction);
}

/// Edges between facets that meet at a feature's angle.
SegmentList feature_segments(const SurfaceMesh& surface) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::vector<Vec3>> normals;
  const auto at = [&](std::int32_t v) { return surface.vertices[static_cast<std::size_t>(v)]; };
  for (const Triangle& t : surface.triangles) {
    const Vec3 normal = (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0]));
    if (!(normal.norm() > 0)) continue;
    for (std::size_t i = 0; i < 3; ++i)
      normals[std::minmax(t[i], t[(i + 1) % 3])].push_back(normal);
  }
  SegmentList segments;
  for (const auto& [edge, around] : normals)
    if (around.size() == 2 &&
        angle_between(around[0], around[1]) > feature_angle_deg * std::numbers::pi / 180)
      segments.emplace_back(facet_point(at(edge.first)), facet_point(at(edge.second)));
  return segments;
}

}  // namespace

struct SurfaceSearch::Impl {
  FacetList facets;
  std::vector<std::size_t> triangle;  ///< of each facet
  std::vector<std::ptrdiff_t> facet;  ///< of each triangle, -1 when degenerate
  FacetTree tree;
  SegmentList segments;
  SegmentTree lines;
};

SurfaceSearch::SurfaceSearch(const SurfaceMesh& surface) : impl_(std::make_unique<Impl>()) {
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto at = [&](std::size_t i) {
      return facet_point(surface.vertices[static_cast<std::size_t>(surface.triangles[t][i])]);
    };
    const Cartesian::Triangle_3 facet(at(0), at(1), at(2));
    impl_->facet.push_back(-1);
    if (facet.is_degenerate()) continue;
    impl_->facet.back() = static_cast<std::ptrdiff_t>(impl_->facets.size());
    impl_->facets.push_back(facet);
    impl_->triangle.push_back(t);
  }
  impl_->tree.rebuild(impl_->facets.cbegin(), impl_->facets.cend());
  impl_->tree.accelerate_distance_queries();
  impl_->segments = feature_segments(surface);
  impl_->lines.rebuild(impl_->segments.cbegin(), impl_->segments.cend());
  if (!impl_->segments.empty()) impl_->lines.accelerate_distance_queries();
}

SurfaceSearch::~SurfaceSearch() = default;
SurfaceSearch::SurfaceSearch(SurfaceSearch&&) noexcept = default;

SurfaceSearch::Hit SurfaceSearch::nearest(const Vec3& point) const {
  const auto [at, facet] = impl_->tree.closest_point_and_primitive(facet_point(point));
  return {coordinates(at),
          impl_->triangle[static_cast<std::size_t>(facet - impl_->facets.cbegin())]};
}

std::optional<SurfaceSearch::Hit> SurfaceSearch::nearest_on_side(const Vec3& point,
                                                                 const Vec3& normal) const {
  const auto number = [&](FacetList::const_iterator facet) {
    return impl_->triangle[static_cast<std::size_t>(facet - impl_->facets.cbegin())];
  };
  const auto [at, facet] = impl_->tree.closest_point_and_primitive(facet_point(point));
  if (normal_of(*facet).dot(normal) > 0) return Hit{coordinates(at), number(facet)};
  const Cartesian::Line_3 line(facet_point(point), facet_point(point + normal));
  std::vector<FacetTree::Primitive_id> hits;
  impl_->tree.all_intersected_primitives(line, std::back_inserter(hits));
  std::optional<Hit> best;
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& hit : hits) {
    const Vec3 facing = normal_of(*hit);
    if (facing.dot(normal) < 0.2) continue;
    const double way = way_to(*hit, facing, point, normal);
    if (std::abs(way) >= shortest) continue;
    shortest = std::abs(way);
    best = Hit{point + way * normal, number(hit)};
  }
  return best;
}

std::optional<Vec3> SurfaceSearch::nearest_on_line(const Vec3& from, const Vec3& to,
                                                   const Vec3& between) const {
  if (impl_->segments.empty()) return std::nullopt;
  const Vec3 way = to - from;
  const double on_it = 1e-7 * way.norm();
  for (const Vec3& end : {from, to})
    if ((coordinates(impl_->lines.closest_point(facet_point(end))) - end).norm() > on_it)
      return std::nullopt;
  const auto [at, segment] = impl_->lines.closest_point_and_primitive(facet_point(between));
  const Vec3 along = coordinates(segment->target()) - coordinates(segment->source());
  constexpr double same_way = 0.7;
  if (std::abs(along.dot(way)) < same_way * along.norm() * way.norm()) return std::nullopt;
  return coordinates(at);
}

SurfaceProjection SurfaceSearch::projection() const {
  return {[this](const Vec3& point, const Vec3& normal) -> Vec3 {
            const auto hit = nearest_on_side(point, normal);
            return hit ? hit->point : point;
          },
          [this](const Vec3& from, const Vec3& to, const Vec3& between) {
            return nearest_on_line(from, to, between);
          }};
}

double SurfaceSearch::thickness_below(std::size_t triangle) const {
  double shortest = std::numeric_limits<double>::infinity();
  if (impl_->facet[triangle] < 0) return shortest;
  const auto& own = impl_->facets[static_cast<std::size_t>(impl_->facet[triangle])];
  const Vec3 middle = (coordinates(own[0]) + coordinates(own[1]) + coordinates(own[2])) / 3;
  const Vec3 inward = -normal_of(own);
  const Cartesian::Ray_3 ray(facet_point(middle), facet_point(middle + inward));
  std::vector<FacetTree::Primitive_id> hits;
  impl_->tree.all_intersected_primitives(ray, std::back_inserter(hits));
  for (const auto& hit : hits) {
    const Vec3 facing = normal_of(*hit);
    if (&*hit == &own || facing.dot(inward) < 0.1) continue;
    const double way = way_to(*hit, facing, middle, inward);
    if (way > 0) shortest = std::min(shortest, way);
  }
  return shortest;
}

}  // namespace carillon::solvers::mesh::tetrahedra
