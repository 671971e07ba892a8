#include "synth/support/support_contacts.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.hpp"
#include "synth/surface/outer_surface.hpp"

namespace carillon::synth::support {

namespace {

double longest_edge(const surface::SurfaceTriangle& t) {
  return std::max({(t.positions[1] - t.positions[0]).norm(),
                   (t.positions[2] - t.positions[1]).norm(),
                   (t.positions[0] - t.positions[2]).norm()});
}

using Corners = std::array<Vec3, 3>;

/// Corners of the four triangles between the corners and the middles of the sides.
std::array<Corners, 4> quarters(const Corners& c) {
  const Vec3 ab = (c[0] + c[1]) / 2, bc = (c[1] + c[2]) / 2, ca = (c[2] + c[0]) / 2;
  return {Corners{c[0], ab, ca}, Corners{ab, c[1], bc}, Corners{ca, bc, c[2]}, Corners{ab, bc, ca}};
}

/// Of the force, by their areas.
void share_out(std::vector<Contact>& contacts) {
  double total = 0;
  for (const Contact& contact : contacts) total += contact.area;
  for (Contact& contact : contacts) contact.fraction = contact.area / total;
}

/// Adds what lies within the radius; pieces are cut until they are small beside it.
void add_within(const surface::SurfaceTriangle& triangle, const Vec3& centre, double radius,
                const solvers::modes::ModeSurface& surface, std::vector<Contact>& contacts) {
  const Vec3 middle = (triangle.positions[0] + triangle.positions[1] + triangle.positions[2]) / 3;
  const double edge = longest_edge(triangle);
  const double distance = (middle - centre).norm();
  if (distance > radius + edge) return;  // no point is farther from the middle than an edge
  if (edge > radius / 4) {
    const auto corners = quarters(triangle.corners);
    const auto positions = quarters(triangle.positions);
    for (std::size_t part = 0; part < 4; ++part) {
      add_within({triangle.face, corners[part], positions[part]}, centre, radius, surface,
                 contacts);
    }
    return;
  }
  const double area = surface::area_vector(triangle).norm();
  if (distance > radius || !(area > 0)) return;
  const modal::SurfacePoint point{
      triangle.face, (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3};
  contacts.push_back({point, modal::frame_at(surface, point).normal, 1, area});
}

/// The part of a triangle at least `level` deep along `down`, as one contact at its centroid.
void add_below(const surface::SurfaceTriangle& triangle, const Vec3& down, double level,
               std::vector<Contact>& contacts) {
  std::array<double, 3> depth;
  for (std::size_t k = 0; k < 3; ++k) depth[k] = triangle.positions[k].dot(down) - level;
  // Corners of the clipped polygon, in the triangle's own barycentric coordinates.
  std::vector<Eigen::Vector3d> polygon;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (depth[k] >= 0) polygon.push_back(Eigen::Vector3d::Unit(static_cast<Eigen::Index>(k)));
    if ((depth[k] >= 0) != (depth[next] >= 0)) {
      const double t = depth[k] / (depth[k] - depth[next]);
      polygon.push_back((1 - t) * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(k)) +
                        t * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(next)));
    }
  }
  double fraction = 0;  // of the triangle's area
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    Eigen::Matrix3d part;
    part << polygon[0], polygon[k - 1], polygon[k];
    const double size = std::abs(part.determinant());
    fraction += size;
    centroid += size * (polygon[0] + polygon[k - 1] + polygon[k]) / 3;
  }
  if (!(fraction > 0)) return;
  centroid /= fraction;
  Eigen::Vector3d on_face = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    on_face += centroid[static_cast<Eigen::Index>(k)] * triangle.corners[k];
  }
  contacts.push_back(
      {{triangle.face, on_face}, down, 1, fraction * surface::area_vector(triangle).norm()});
}

void check_length(double length, const char* name) {
  if (!(length >= 0) || !std::isfinite(length)) {
    throw core::InputError(
        fmt::format("support: {} must be finite and not negative, not {} m", name, length));
  }
}

}  // namespace

std::vector<Contact> point_contact(const solvers::modes::ModeSurface& surface,
                                   const modal::SurfacePoint& point) {
  return {{point, modal::frame_at(surface, point).normal, 1.0}};
}

std::vector<Contact> patch_contacts(const solvers::modes::ModeSurface& surface,
                                    std::span<const surface::SurfaceTriangle> triangles,
                                    const modal::SurfacePoint& centre, double radius) {
  check_length(radius, "the radius of a patch");
  std::vector<Contact> contacts;
  const modal::PointFrame middle = modal::frame_at(surface, centre);
  if (radius > 0) {
    for (const surface::SurfaceTriangle& triangle : triangles) {
      if (surface::area_vector(triangle).dot(middle.normal) > 0) {
        add_within(triangle, middle.position, radius, surface, contacts);
      }
    }
  }
  if (contacts.empty()) return point_contact(surface, centre);
  share_out(contacts);
  return contacts;
}

std::vector<Contact> lowest_contacts(const solvers::modes::ModeSurface& surface, const Vec3& down,
                                     double height) {
  check_length(height, "the height of the contact above the lowest point");
  if (!(std::abs(down.norm() - 1) <= 1e-6)) {
    throw core::InputError(
        fmt::format("support: down must be a unit vector, its length is {}", down.norm()));
  }
  // Walls that stand upright do not touch the ground.
  constexpr double looks_down = 0.05;
  const std::vector<surface::SurfaceTriangle> triangles = surface::outer_pieces(surface);
  double deepest = -std::numeric_limits<double>::infinity();
  Contact lowest{{0, {1, 0, 0}}, down, 1.0};
  for (const surface::SurfaceTriangle& triangle : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double depth = triangle.positions[k].dot(down);
      if (depth > deepest) {
        deepest = depth;
        lowest.point = {triangle.face, triangle.corners[k]};
      }
    }
  }
  std::vector<Contact> contacts;
  for (const surface::SurfaceTriangle& triangle : triangles) {
    const Vec3 area = surface::area_vector(triangle);
    if (area.dot(down) > looks_down * area.norm()) {
      add_below(triangle, down, deepest - height, contacts);
    }
  }
  if (contacts.empty()) return {lowest};
  share_out(contacts);
  return contacts;
}

std::vector<Contact> edge_contacts(const solvers::modes::ModeSurface& surface,
                                   const modal::SurfaceSampler& sampler,
                                   std::span<const Vec3> polyline, int points) {
  if (polyline.empty()) throw core::InputError("support: an edge without corners");
  if (points < 1) throw core::InputError("support: an edge needs at least one point of contact");
  std::vector<double> reached = {0.0};  // length up to each corner
  for (std::size_t k = 0; k < polyline.size(); ++k) {
    if (!polyline[k].allFinite()) {
      throw core::InputError(fmt::format("support: corner {} of an edge is not finite", k));
    }
    if (k > 0) reached.push_back(reached.back() + (polyline[k] - polyline[k - 1]).norm());
  }
  std::vector<Contact> contacts;
  std::size_t segment = 0;
  for (int i = 0; i < points; ++i) {
    const double along = reached.back() * (i + 0.5) / points;
    while (segment + 2 < polyline.size() && reached[segment + 1] < along) ++segment;
    Vec3 position = polyline.front();
    if (reached.back() > 0) {
      const double length = reached[segment + 1] - reached[segment];
      const double t = length > 0 ? (along - reached[segment]) / length : 0;
      position = (1 - t) * polyline[segment] + t * polyline[segment + 1];
    }
    const modal::SurfacePoint point = sampler.nearest(position);
    contacts.push_back({point, modal::frame_at(surface, point).normal, 1.0 / points});
  }
  return contacts;
}

double area_of(std::span<const Contact> contacts) {
  return std::accumulate(contacts.begin(), contacts.end(), 0.0,
                         [](double sum, const Contact& contact) { return sum + contact.area; });
}

Vec3 centre_of(const solvers::modes::ModeSurface& surface, std::span<const Contact> contacts) {
  Vec3 centre = Vec3::Constant(0);
  for (const Contact& contact : contacts) {
    centre += contact.fraction * modal::frame_at(surface, contact.point).position;
  }
  return centre;
}

}  // namespace carillon::synth::support
