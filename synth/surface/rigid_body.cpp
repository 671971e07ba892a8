#include "synth/surface/rigid_body.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "synth/surface/outer_surface.hpp"

namespace carillon::synth::surface {

namespace {

void check_mass(double mass) {
  if (mass > 0 && std::isfinite(mass)) return;
  throw core::InputError(fmt::format("rigid motion of a body of {} kg", mass));
}

/// Moments of tetrahedra about an origin near them: far from it they would cancel.
struct Sums {
  Vec3 origin = Vec3::Zero();
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();

  void add(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    Eigen::Matrix<double, 3, 4> p;
    p << a - origin, b - origin, c - origin, d - origin;
    const double part = solvers::mesh::six_volumes(a, b, c, d) / 6;
    const Vec3 sum = p.rowwise().sum();
    volume += part;
    first += part / 4 * sum;
    second += part / 20 * (p * p.transpose() + sum * sum.transpose());
  }
  RegionMoments moments() const {
    const Vec3 middle = first / volume;
    return {volume, origin + middle, second / volume - middle * middle.transpose()};
  }
};

/// @param spread  mean of r r^T about the centre, weighted by mass
RigidBody body_of(double mass, const Vec3& centre, const Eigen::Matrix3d& spread) {
  RigidBody body;
  body.mass = mass;
  body.centre = centre;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(spread);
  body.axes = principal.eigenvectors();
  const Vec3 squares = principal.eigenvalues();
  // A thread or a leaf has next to no extent across, but never none.
  const double minimum = 1e-12 * squares.sum();
  for (Eigen::Index k = 0; k < 3; ++k) {
    body.inertia[k] = mass * std::max(squares.sum() - squares[k], minimum);
  }
  return body;
}

}  // namespace

RigidBody rigid_body(const solvers::modes::Modes& modes) {
  const solvers::modes::ModeSurface& surface = modes.surface;
  check_mass(modes.mass);
  const auto per_face = static_cast<std::size_t>(solvers::elements::nodes_per_face(surface.order));
  Sums sums;
  if (!surface.nodes.empty()) sums.origin = surface.nodes.front();
  const std::vector<FacePiece> pieces = face_pieces(surface.order);
  for (std::size_t face = 0; face < surface.faces.size() / per_face; ++face) {
    const auto nodes = face_nodes(surface, static_cast<std::int32_t>(face));
    const auto at = [&](std::int32_t corner) {
      return surface.nodes[static_cast<std::size_t>(nodes[static_cast<std::size_t>(corner)])];
    };
    for (const FacePiece& piece : pieces) {
      sums.add(sums.origin, at(piece.nodes[0]), at(piece.nodes[1]), at(piece.nodes[2]));
    }
  }
  if (!(sums.volume > 0) || !std::isfinite(sums.volume)) {
    throw core::InputError(fmt::format("rigid motion: the surface encloses {} m^3", sums.volume),
                           "a closed surface that looks outward is needed");
  }
  const RegionMoments whole = sums.moments();
  return body_of(modes.mass, whole.centroid, whole.spread);
}

std::vector<RegionMoments> region_moments(const solvers::mesh::TetMesh& mesh) {
  std::vector<Sums> sums(mesh.region_names.size());
  for (std::size_t e = 0; e < mesh.element_count(); ++e) {
    const auto nodes = mesh.element(e);
    const auto at = [&](std::size_t corner) {
      return mesh.nodes[static_cast<std::size_t>(nodes[corner])];
    };
    Sums& own = sums[static_cast<std::size_t>(mesh.regions[e])];
    if (own.volume == 0) own.origin = at(0);
    own.add(at(0), at(1), at(2), at(3));
  }
  std::vector<RegionMoments> regions;
  for (std::size_t r = 0; r < sums.size(); ++r) {
    if (!(sums[r].volume > 0)) {
      throw core::InputError(fmt::format("rigid motion: region {} has a volume of {} m^3",
                                         mesh.region_names[r], sums[r].volume));
    }
    regions.push_back(sums[r].moments());
  }
  return regions;
}

RigidBody rigid_body(std::span<const RegionMoments> regions, std::span<const double> densities,
                     double mass) {
  check_mass(mass);
  if (regions.empty() || regions.size() != densities.size()) {
    throw core::InputError(
        fmt::format("rigid motion: {} densities of {} regions", densities.size(), regions.size()));
  }
  double whole = 0;
  Vec3 centre = Vec3::Zero();
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const double part = densities[r] * regions[r].volume;
    whole += part;
    centre += part * regions[r].centroid;
  }
  if (!(whole > 0) || !std::isfinite(whole)) {
    throw core::InputError(fmt::format("rigid motion: densities that add up to {} kg", whole));
  }
  centre /= whole;
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const Vec3 arm = regions[r].centroid - centre;
    spread +=
        densities[r] * regions[r].volume / whole * (regions[r].spread + arm * arm.transpose());
  }
  return body_of(mass, centre, spread);
}

Eigen::Matrix<double, 6, 3> rigid_shapes_at(const RigidBody& body, const Vec3& position) {
  Eigen::Matrix<double, 6, 3> shapes;
  shapes.topRows<3>() = Eigen::Matrix3d::Identity() / std::sqrt(body.mass);
  const Vec3 arm = position - body.centre;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vec3 axis = body.axes.col(k);
    shapes.row(3 + k) = axis.cross(arm).transpose() / std::sqrt(body.inertia[k]);
  }
  return shapes;
}

}  // namespace carillon::synth::surface
