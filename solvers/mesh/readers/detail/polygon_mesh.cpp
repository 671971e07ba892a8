#include "solvers/mesh/readers/detail/polygon_mesh.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

double cross(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 u = b - a;
  const Vec2 v = c - a;
  return u.x() * v.y() - u.y() * v.x();
}

/// The polygon's corners in the plane of Newell's normal, counter-clockwise.
std::vector<Vec2> project_on_plane(const std::vector<Vec3>& vertices,
                                   std::span<const std::int32_t> polygon) {
  const auto point = [&](std::size_t i) {
    return vertices[static_cast<std::size_t>(polygon[i % polygon.size()])];
  };
  Vec3 normal = Vec3::Zero();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    normal += (point(i) - point(0)).cross(point(i + 1) - point(0));
  }
  // A polygon without area has no plane; any will do.
  if (!(normal.norm() > 0)) normal = Vec3::UnitZ();
  normal.normalize();
  const Vec3 u = normal.unitOrthogonal();
  const Vec3 v = normal.cross(u);
  std::vector<Vec2> flat;
  flat.reserve(polygon.size());
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 p = point(i) - point(0);
    flat.emplace_back(p.dot(u), p.dot(v));
  }
  return flat;
}

bool strictly_convex(const std::vector<Vec2>& flat) {
  const std::size_t n = flat.size();
  // Turning left at every corner is not enough for n > 4 (stars do too): from the first corner the
  // others must be seen in order as well.
  for (std::size_t i = 0; i < n; ++i) {
    if (!(cross(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) > 0)) return false;
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (!(cross(flat[0], flat[i], flat[i + 1]) > 0)) return false;
  }
  return true;
}

bool holds(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& p) {
  if (p == a || p == b || p == c) return false;  // rings joined by a bridge repeat corners
  return cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0;
}

/// An ear at position i of the ring: turns left and has no other corner inside.
bool is_ear(const std::vector<Vec2>& flat, const std::vector<std::size_t>& ring, std::size_t i) {
  const std::size_t n = ring.size();
  const Vec2& a = flat[ring[(i + n - 1) % n]];
  const Vec2& b = flat[ring[i]];
  const Vec2& c = flat[ring[(i + 1) % n]];
  if (!(cross(a, b, c) > 0)) return false;
  for (std::size_t k = 2; k + 1 < n; ++k) {
    if (holds(a, b, c, flat[ring[(i + k) % n]])) return false;
  }
  return true;
}

}  // namespace

void triangulate_polygon(const std::vector<Vec3>& vertices, std::span<const std::int32_t> polygon,
                         std::vector<Triangle>& triangles) {
  if (polygon.size() < 3) return;
  if (polygon.size() == 3) {
    triangles.push_back({polygon[0], polygon[1], polygon[2]});
    return;
  }
  const std::vector<Vec2> flat = project_on_plane(vertices, polygon);
  if (strictly_convex(flat)) {
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
      triangles.push_back({polygon[0], polygon[i], polygon[i + 1]});
    }
    return;
  }
  std::vector<std::size_t> ring(polygon.size());
  for (std::size_t i = 0; i < ring.size(); ++i) ring[i] = i;
  std::size_t start = 0;
  while (ring.size() > 3) {
    const std::size_t n = ring.size();
    std::size_t ear = start % n;  // kept when there is no ear: the polygon crosses itself
    for (std::size_t k = 0; k < n; ++k) {
      if (is_ear(flat, ring, (start + k) % n)) {
        ear = (start + k) % n;
        break;
      }
    }
    triangles.push_back(
        {polygon[ring[(ear + n - 1) % n]], polygon[ring[ear]], polygon[ring[(ear + 1) % n]]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(ear));
    // The next ear is looked for beyond its neighbour, which spreads the cuts around the ring.
    start = ear + 1;
  }
  triangles.push_back({polygon[ring[0]], polygon[ring[1]], polygon[ring[2]]});
}

SurfaceMesh triangulate(PolygonMesh polygons) {
  SurfaceMesh mesh;
  mesh.triangles.reserve(polygons.ends.size());
  std::size_t begin = 0;
  for (const std::size_t end : polygons.ends) {
    triangulate_polygon(polygons.vertices, std::span(polygons.corners).subspan(begin, end - begin),
                        mesh.triangles);
    begin = end;
  }
  if (!polygons.not_finite.empty()) {
    for (const Triangle& t : mesh.triangles)
      for (const std::int32_t v : t)
        if (const auto found = polygons.not_finite.find(v); found != polygons.not_finite.end())
          throw core::InputError(
              fmt::format("{}: vertex {}, which a face uses, is not finite", found->second, v + 1));
  }
  mesh.vertices = std::move(polygons.vertices);
  drop_unreferenced(mesh);
  return mesh;
}

}  // namespace carillon::solvers::mesh::readers
