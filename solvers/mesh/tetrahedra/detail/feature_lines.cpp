#include "solvers/mesh/tetrahedra/detail/feature_lines.hpp"

#include <Eigen/Geometry>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "solvers/mesh/simplify/cgal_mesh.hpp"
#include "solvers/mesh/simplify/cgal_trees.hpp"

namespace carillon::solvers::mesh::tetrahedra {
namespace {

using simplify::from_cgal;
using simplify::to_cgal;
using SegmentList = simplify::CgalSegments<simplify::CgalKernel>;
using SegmentTree = simplify::CgalSegmentTree<simplify::CgalKernel>;

/// Edges between triangles that meet at a feature's angle.
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
      segments.emplace_back(to_cgal(at(edge.first)), to_cgal(at(edge.second)));
  return segments;
}

}  // namespace

struct FeatureLines::Impl {
  SegmentList segments;
  SegmentTree tree;
};

FeatureLines::FeatureLines(const SurfaceMesh& surface) : impl_(std::make_unique<Impl>()) {
  impl_->segments = feature_segments(surface);
  impl_->tree.rebuild(impl_->segments.cbegin(), impl_->segments.cend());
  if (!impl_->segments.empty()) impl_->tree.accelerate_distance_queries();
}

FeatureLines::~FeatureLines() = default;

std::optional<Vec3> FeatureLines::nearest(const Vec3& from, const Vec3& to,
                                          const Vec3& between) const {
  if (impl_->segments.empty()) return std::nullopt;
  const Vec3 way = to - from;
  const double on_it = 1e-7 * way.norm();
  for (const Vec3& end : {from, to})
    if ((from_cgal(impl_->tree.closest_point(to_cgal(end))) - end).norm() > on_it)
      return std::nullopt;
  const auto [at, segment] = impl_->tree.closest_point_and_primitive(to_cgal(between));
  const Vec3 along = from_cgal(segment->target()) - from_cgal(segment->source());
  constexpr double same_way = 0.7;
  if (std::abs(along.dot(way)) < same_way * along.norm() * way.norm()) return std::nullopt;
  return from_cgal(at);
}

SurfaceProjection projection_on(const SurfaceSearch& surface, const FeatureLines& lines) {
  return {[&surface](const Vec3& point, const Vec3& normal) -> Vec3 {
            const auto hit = surface.nearest_on_side(point, normal);
            return hit ? hit->point : point;
          },
          [&lines](const Vec3& from, const Vec3& to, const Vec3& between) {
            return lines.nearest(from, to, between);
          }};
}

}  // namespace carillon::solvers::mesh::tetrahedra
