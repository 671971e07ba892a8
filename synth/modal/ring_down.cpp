#include "synth/modal/ring_down.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "solvers/elements/lagrange.hpp"
#include "synth/surface/outer_surface.hpp"

namespace carillon::synth::modal {

namespace {

/// How far a direction may be from unit length, and barycentric coordinates from summing to one.
constexpr double tolerance = 1e-6;

void check_point(const SurfacePoint& point) {
  const auto& b = point.barycentric;
  if (!b.allFinite() || std::abs(b.sum() - 1) > tolerance || b.minCoeff() < -tolerance) {
    throw core::InputError(
        fmt::format("surface point: barycentric coordinates ({}, {}, {}) are not a point of a face",
                    b[0], b[1], b[2]));
  }
}

void check_strike(const Strike& strike) {
  const double length = strike.direction.norm();
  if (!(std::abs(length - 1) <= tolerance)) {
    throw core::InputError(
        fmt::format("strike: the direction must be a unit vector, its length is {}", length));
  }
  if (!std::isfinite(strike.impulse)) throw core::InputError("strike: the impulse is not finite");
}

}  // namespace

PointFrame frame_at(const solvers::modes::ModeSurface& surface, const SurfacePoint& point) {
  check_point(point);
  const auto nodes = surface::face_nodes(surface, point.face);
  Eigen::Matrix<double, Eigen::Dynamic, 3> gradient;
  const Eigen::VectorXd values =
      solvers::elements::triangle_shape_functions(surface.order, point.barycentric, &gradient);
  PointFrame frame{Vec3::Constant(0), Vec3::Constant(0)};
  Vec3 first = Vec3::Constant(0);
  Vec3 second = Vec3::Constant(0);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const Vec3& node = surface.nodes[static_cast<std::size_t>(nodes[a])];
    const auto row = static_cast<Eigen::Index>(a);
    frame.position += values[row] * node;
    first += (gradient(row, 1) - gradient(row, 0)) * node;
    second += (gradient(row, 2) - gradient(row, 0)) * node;
  }
  Vec3 normal = first.cross(second);
  if (!(normal.norm() > 0)) {
    // A corner where the curved face folds to a line: the straight face still knows its side.
    const auto corner = [&](std::size_t k) {
      return surface.nodes[static_cast<std::size_t>(nodes[k])];
    };
    normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
  }
  if (!(normal.norm() > 0)) {
    throw core::InputError(fmt::format("surface point: face {} has no area", point.face));
  }
  frame.normal = normal.normalized();
  return frame;
}

Eigen::MatrixX3d shapes_at(const solvers::modes::Modes& modes, const SurfacePoint& point) {
  check_point(point);
  const auto nodes = surface::face_nodes(modes.surface, point.face);
  const Eigen::VectorXd values =
      solvers::elements::triangle_shape_functions(modes.surface.order, point.barycentric, nullptr);
  Eigen::MatrixX3d shapes = Eigen::MatrixX3d::Zero(modes.shapes.modes(), 3);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    shapes +=
        values[static_cast<Eigen::Index>(a)] * modes.shapes.at(static_cast<Eigen::Index>(nodes[a]));
  }
  return shapes;
}

Vec3 spread_direction(const Vec3& axis, double spread, core::RandomStream& random) {
  if (!(spread > 0)) return axis;
  const double cosine = 1 - random.uniform() * (1 - std::cos(spread));
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const double turn = 2 * std::numbers::pi * random.uniform();
  const Vec3 side = axis.unitOrthogonal();
  return cosine * axis + sine * (std::cos(turn) * side + std::sin(turn) * axis.cross(side));
}

RingDown ring_down(const solvers::modes::Modes& modes, std::span<const double> decay_rates,
                   const Strike& strike, const Readout& readout) {
  if (decay_rates.size() != modes.size()) {
    throw core::InputError(
        fmt::format("ring down: {} decay rates for {} modes", decay_rates.size(), modes.size()));
  }
  check_strike(strike);
  RingDown rings;
  rings.eigenvalues = modes.eigenvalues;
  rings.decay_rates.assign(decay_rates.begin(), decay_rates.end());
  rings.excitation = shapes_at(modes, strike.point) * (strike.impulse * strike.direction);
  rings.readout = readout;
  return rings;
}

double t60(double decay_rate) {
  return std::log(1000.0) / decay_rate;
}

void leave_out(RingDown& rings, std::span<const std::size_t> modes) {
  for (const std::size_t mode : modes) {
    const auto column = static_cast<Eigen::Index>(mode);
    if (column >= rings.excitation.size()) {
      throw core::InputError(fmt::format("leave out: there is no mode {}", mode));
    }
    rings.excitation[column] = 0;
    for (Eigen::MatrixXd* gains : gains_of(rings.readout)) {
      if (gains->size() != 0) gains->col(column).setZero();
    }
  }
}

}  // namespace carillon::synth::modal
