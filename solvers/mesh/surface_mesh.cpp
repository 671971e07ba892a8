#include "solvers/mesh/surface_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <tuple>
#include <utility>

#include "core/disjoint_sets.hpp"

namespace carillon::solvers::mesh {
namespace {

const Vec3& corner(const SurfaceMesh& mesh, const Triangle& t, std::size_t i) {
  return mesh.vertices[static_cast<std::size_t>(t[i])];
}

}  // namespace

double signed_volume(const SurfaceMesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  // Taken about a point of the mesh: far from the origin the sum would lose its digits.
  const Vec3 origin = mesh.vertices.front();
  double six_volumes = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = corner(mesh, t, 0) - origin;
    const Vec3 b = corner(mesh, t, 1) - origin;
    const Vec3 c = corner(mesh, t, 2) - origin;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

double area(const SurfaceMesh& mesh) {
  double twice = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3& a = corner(mesh, t, 0);
    twice += (corner(mesh, t, 1) - a).cross(corner(mesh, t, 2) - a).norm();
  }
  return twice / 2;
}

double angle_between(const Vec3& one, const Vec3& two) {
  return std::atan2(one.cross(two).norm(), one.dot(two));
}

double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double up = a.dot(b.cross(c));
  const double down = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2 * std::atan2(up, down);
}

double winding_number(const SurfaceMesh& mesh, const Vec3& point) {
  double angle = 0;
  for (const Triangle& t : mesh.triangles) {
    angle += solid_angle(corner(mesh, t, 0) - point, corner(mesh, t, 1) - point,
                         corner(mesh, t, 2) - point);
  }
  return angle / (4 * std::numbers::pi);
}

Box bounding_box(const std::vector<Vec3>& points) {
  Box box;
  if (points.empty()) return box;
  box.low = box.high = points.front();
  for (const Vec3& p : points) {
    box.low = box.low.cwiseMin(p);
    box.high = box.high.cwiseMax(p);
  }
  return box;
}

std::vector<std::int32_t> edge_components(const std::vector<Triangle>& triangles) {
  struct EdgeUse {
    std::int32_t low, high, triangle;
    bool operator<(const EdgeUse& o) const {
      return std::tie(low, high, triangle) < std::tie(o.low, o.high, o.triangle);
    }
  };
  std::vector<EdgeUse> uses;
  uses.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangles[t][i], triangles[t][(i + 1) % 3]);
      uses.push_back({low, high, static_cast<std::int32_t>(t)});
    }
  }
  std::sort(uses.begin(), uses.end());

  core::DisjointSets joined(triangles.size());
  for (std::size_t k = 1; k < uses.size(); ++k) {
    if (uses[k].low != uses[k - 1].low || uses[k].high != uses[k - 1].high) continue;
    joined.join(static_cast<std::size_t>(uses[k - 1].triangle),
                static_cast<std::size_t>(uses[k].triangle));
  }

  // Sets are named by their first triangle, so numbers come out in the promised order.
  std::vector<std::int32_t> component(triangles.size());
  std::int32_t count = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::size_t first = joined.find(t);
    component[t] = first == t ? count++ : component[first];
  }
  return component;
}

std::vector<SurfaceMesh> split(const SurfaceMesh& mesh,
                               const std::vector<std::int32_t>& component) {
  std::int32_t count = 0;
  for (const std::int32_t c : component) count = std::max(count, c + 1);
  std::vector<SurfaceMesh> pieces(static_cast<std::size_t>(count));
  for (std::size_t t = 0; t < component.size(); ++t) {
    pieces[static_cast<std::size_t>(component[t])].triangles.push_back(mesh.triangles[t]);
  }
  std::vector<std::int32_t> renumbered(mesh.vertices.size(), -1);
  for (SurfaceMesh& piece : pieces) {
    std::vector<std::int32_t> used;
    for (Triangle& t : piece.triangles) {
      for (std::int32_t& v : t) {
        std::int32_t& fresh = renumbered[static_cast<std::size_t>(v)];
        if (fresh < 0) {
          fresh = static_cast<std::int32_t>(used.size());
          used.push_back(v);
          piece.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
        }
        v = fresh;
      }
    }
    for (const std::int32_t v : used) renumbered[static_cast<std::size_t>(v)] = -1;
  }
  return pieces;
}

}  // namespace carillon::solvers::mesh
