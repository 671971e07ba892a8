#include "solvers/mesh/tetrahedra/surface_search.hpp"

#include <CGAL/Simple_cartesian.h>

#include <Eigen/Geometry>
#include <limits>

#include "solvers/mesh/simplify/cgal_trees.hpp"

namespace carillon::solvers::mesh::tetrahedra {
namespace {

using Cartesian = CGAL::Simple_cartesian<double>;
using FacetList = simplify::CgalTriangles<Cartesian>;
using FacetTree = simplify::CgalTriangleTree<Cartesian>;

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

}  // namespace

struct SurfaceSearch::Impl {
  FacetList facets;
  std::vector<std::size_t> triangle;  ///< of each facet
  std::vector<std::ptrdiff_t> facet;  ///< of each triangle, -1 when degenerate
  FacetTree tree;
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
