#include "synth/motion/detail/collision_shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "solvers/mesh/surface_mesh.hpp"
#include "synth/motion/convex_hull.hpp"
#include "synth/motion/detail/bullet_vectors.hpp"

namespace carillon::synth::motion {

using solvers::mesh::SurfaceMesh;

namespace {

/// Corners of a piece that Bullet is given at the most: of a rounded one those that reach farthest
/// in so many directions, evenly spread.
constexpr int max_corners = 192;
/// Bullet's margin around hulls, in its units.
constexpr btScalar margin = 5e-4;

/// Those that reach farthest in directions of a Fibonacci lattice.
std::vector<Vec3> fewer_points(const std::vector<Vec3>& points) {
  if (points.size() <= max_corners) return points;
  std::vector<bool> kept(points.size(), false);
  for (int k = 0; k < 2 * max_corners; ++k) {
    const double z = 1 - (2 * k + 1.0) / (2 * max_corners);
    const double turn = k * std::numbers::pi * (3 - std::sqrt(5.0)), r = std::sqrt(1 - z * z);
    const Vec3 direction(r * std::cos(turn), r * std::sin(turn), z);
    std::size_t farthest = 0;
    for (std::size_t p = 1; p < points.size(); ++p) {
      if (points[p].dot(direction) > points[farthest].dot(direction)) farthest = p;
    }
    kept[farthest] = true;
  }
  std::vector<Vec3> few;
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (kept[p]) few.push_back(points[p]);
  }
  return few;
}

/// Smallest half-extent over the directions of the hull's faces.
double thinnest_of(const SurfaceMesh& hull) {
  double thinnest = 0.5 * solvers::mesh::bounding_box(hull.vertices).extent().minCoeff();
  for (const solvers::mesh::Triangle& t : hull.triangles) {
    const auto at = [&](std::size_t k) { return hull.vertices[static_cast<std::size_t>(t[k])]; };
    const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    if (!normal.allFinite()) continue;
    double low = 0, high = 0;
    for (const Vec3& p : hull.vertices) {
      const double height = normal.dot(p - at(0));
      low = std::min(low, height);
      high = std::max(high, height);
    }
    if (high - low > 0) thinnest = std::min(thinnest, 0.5 * (high - low));
  }
  return thinnest;
}

}  // namespace

Eigen::Quaterniond principal_turn(const surface::RigidBody& rigid) {
  Eigen::Matrix3d axes = rigid.axes;
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);  // an axis has no sign of its own
  return Eigen::Quaterniond(axes).normalized();
}

double reach_of(const MovingBody& body) {
  double reach = body.ball_radius;
  if (body.ball_radius > 0) return reach;
  for (const auto& piece : body.hulls) {
    for (const Vec3& p : piece) reach = std::max(reach, (p - body.rigid.centre).norm());
  }
  return reach;
}

double median_reach(std::span<const MovingBody> bodies) {
  std::vector<double> reaches;
  for (const MovingBody& body : bodies) {
    if (!body.fixed) reaches.push_back(reach_of(body));
  }
  if (reaches.empty()) return 1;
  std::nth_element(reaches.begin(), reaches.begin() + static_cast<long>(reaches.size() / 2),
                   reaches.end());
  const double unit = reaches[reaches.size() / 2];
  return unit > 0 ? unit : 1;
}

CollisionShape collision_shape(const MovingBody& body, double unit, double skin) {
  CollisionShape shape;
  shape.reach = reach_of(body);
  if (body.ball_radius > 0) {
    shape.whole = std::make_unique<btSphereShape>(body.ball_radius / unit);
    shape.thinnest = body.ball_radius;
    return shape;
  }
  shape.thinnest = shape.reach;
  auto compound = std::make_unique<btCompoundShape>();
  const Eigen::Quaterniond turn = principal_turn(body.rigid).conjugate();
  std::vector<Vec3> all;
  for (const std::vector<Vec3>& piece : body.hulls) {
    const SurfaceMesh hull = convex_hull(piece);
    const double volume = solvers::mesh::signed_volume(hull);
    if (!(volume > 0)) {
      throw core::InputError(
          fmt::format("{}: a piece of {} points encloses no volume", body.name, piece.size()),
          "bodies that move need a hull with a volume");
    }
    const solvers::mesh::Box box = solvers::mesh::bounding_box(hull.vertices);
    const Vec3 half = 0.5 * box.extent();
    std::unique_ptr<btCollisionShape> part;
    btTransform place = btTransform::getIdentity();
    if (volume > (1 - 1e-6) * box.extent().prod()) {
      if (body.hulls.size() == 1) shape.skin = skin;
      part = std::make_unique<btBoxShape>(to_bullet((half + Vec3::Constant(shape.skin)) / unit));
      part->setMargin(margin);
      const Vec3 middle = turn * (0.5 * (box.low + box.high) - body.rigid.centre);
      place.setOrigin(to_bullet(middle / unit));
      place.setRotation({turn.x(), turn.y(), turn.z(), turn.w()});
      shape.thinnest = std::min(shape.thinnest, half.minCoeff());
    } else {
      shape.thinnest = std::min(shape.thinnest, thinnest_of(hull));
      auto convex = std::make_unique<btConvexHullShape>();
      for (const Vec3& p : fewer_points(hull.vertices)) {
        convex->addPoint(to_bullet(turn * (p - body.rigid.centre) / unit), false);
      }
      convex->setMargin(margin);
      convex->recalcLocalAabb();
      convex->initializePolyhedralFeatures();
      part = std::move(convex);
    }
    compound->addChildShape(place, part.get());
    shape.parts.push_back(std::move(part));
    all.insert(all.end(), hull.vertices.begin(), hull.vertices.end());
  }
  shape.hull = convex_hull(all);
  shape.whole = std::move(compound);
  return shape;
}

}  // namespace carillon::synth::motion
