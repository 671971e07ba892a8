#include "synth/rigid_body.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "synth/outer_surface.hpp"

namespace carillon::synth {

RigidBody rigid_body(const solvers::Modes& modes) {
  const solvers::ModeSurface& surface = modes.surface;
  if (!(modes.mass > 0) || !std::isfinite(modes.mass)) {
    throw core::InputError(fmt::format("rigid motion of a body of {} kg", modes.mass));
  }
  const auto per_face = static_cast<std::size_t>(solvers::nodes_per_face(surface.order));
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  // Far from the origin the moments would cancel.
  const Vec3 origin = surface.nodes.empty() ? Vec3(Vec3::Zero()) : surface.nodes.front();
  const std::vector<FacePiece> pieces = face_pieces(surface.order);
  for (std::size_t face = 0; face < surface.faces.size() / per_face; ++face) {
    const auto nodes = face_nodes(surface, static_cast<std::int32_t>(face));
    for (const FacePiece& piece : pieces) {
      Eigen::Matrix3d p;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto node = nodes[static_cast<std::size_t>(piece.nodes[k])];
        p.col(static_cast<Eigen::Index>(k)) =
            surface.nodes[static_cast<std::size_t>(node)] - origin;
      }
      const double part = p.determinant() / 6;
      const Vec3 sum = p.rowwise().sum();
      volume += part;
      first += part / 4 * sum;
      second += part / 20 * (p * p.transpose() + sum * sum.transpose());
    }
  }
  if (!(volume > 0) || !std::isfinite(volume)) {
    throw core::InputError(fmt::format("rigid motion: the surface encloses {} m^3", volume),
                           "a closed surface that looks outward is needed");
  }
  RigidBody body;
  body.mass = modes.mass;
  const Vec3 middle = first / volume;
  body.centre = origin + middle;
  const Eigen::Matrix3d spread = second / volume - middle * middle.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(spread);
  body.axes = principal.eigenvectors();
  const Vec3 squares = principal.eigenvalues();
  // A thread or a leaf has next to no extent across, but never none.
  const double least = 1e-12 * squares.sum();
  for (Eigen::Index k = 0; k < 3; ++k) {
    body.inertia[k] = modes.mass * std::max(squares.sum() - squares[k], least);
  }
  return body;
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

}  // namespace carillon::synth
