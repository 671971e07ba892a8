#include "synth/support/supports.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"

namespace carillon::synth::support {

namespace {

constexpr double standard_gravity = 9.80665;  ///< [m/s^2]
/// Squares of anything faster could overflow later.
constexpr double fastest_damping = 1e50;  ///< [1/s]

bool finite_and_not_negative(double value) {
  return value >= 0 && std::isfinite(value);
}

/// @param unit_trace  of the damping for 1 N s/m
void check_press(double coefficient, double force, double unit_trace) {
  check_support({.name = "", .coefficient = coefficient});
  if (!finite_and_not_negative(force)) {
    throw core::InputError(
        fmt::format("support: the force must be finite and not negative, not {} N", force));
  }
  if (!(coefficient * force * unit_trace < fastest_damping)) {
    throw core::InputError(
        fmt::format("support: a coefficient of {} s/m and a force of {} N damp faster than {} 1/s",
                    coefficient, force, fastest_damping),
        "lower the coefficient or the force");
  }
}

}  // namespace

const std::vector<SupportKind>& preset_supports() {
  static const std::vector<SupportKind> presets = {
      {.name = "finger",
       .coefficient = 1.0,
       .friction = 0.8,
       .source = "chosen: 1 N s/m for a touch of 1 N; skin grips"},
      {.name = "string",
       .coefficient = 0.05,
       .friction = 0.3,
       .source = "chosen: a thread gives way and takes little"},
      {.name = "foam",
       .coefficient = 0.5,
       .friction = 0.6,
       .source = "chosen: soft cells, half of what a finger takes at the same force"},
      {.name = "table",
       .coefficient = 3.0,
       .friction = 0.4,
       .source = "chosen: wood that takes vibration and radiates it"},
      {.name = "felt",
       .source = "chosen: a strip of 5 mm, 0.5 MPa, a loss factor of 0.3 at 500 Hz",
       .bed_stiffness = 1e8,
       .bed_resistance = 1e4,
       .shear = 0.4},
      {.name = "rubber",
       .source = "chosen: a foot of 10 mm, 2 MPa, 1 cm^2, a loss factor of 0.1 at 500 Hz",
       .stiffness = 2e4,
       .resistance = 0.6,
       .shear = 0.4},
      {.name = "screw",
       .source = "chosen: M5 through 10 mm of steel, 20 mm^2, a loss factor of 0.01 at 2 kHz",
       .stiffness = 4e8,
       .resistance = 300},
      {.name = "soil",
       .source = "waves into a half space (Lysmer and Kuhlemeyer 1969): dry sand of 1,700 kg/m^3, "
                 "300 and 150 m/s; Winkler's bed of 30 MN/m^3 (Bowles 1996, table 9-1)",
       .bed_stiffness = 3e7,
       .bed_resistance = 5.1e5,
       .shear = 0.5},
  };
  return presets;
}

SupportKind parse_support(const std::string& name) {
  std::vector<std::string> names;
  for (const SupportKind& kind : preset_supports()) {
    if (kind.name == name) return kind;
    names.push_back(kind.name);
  }
  const std::string nearest = core::nearest_name(name, names);
  throw core::InputError(
      fmt::format("support: unknown kind \"{}\"{}", name,
                  nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest)),
      fmt::format("kinds are {}; or give own numbers", fmt::join(names, ", ")));
}

void check_support(const SupportKind& kind) {
  if (!finite_and_not_negative(kind.coefficient)) {
    throw core::InputError(
        fmt::format("support: the coefficient must be finite and not negative, not {} s/m",
                    kind.coefficient),
        "a negative one would feed energy into the object");
  }
  if (!finite_and_not_negative(kind.friction)) {
    throw core::InputError(
        fmt::format("support: friction must be finite and not negative, not {}", kind.friction));
  }
  const std::pair<const char*, double> others[] = {{"stiffness", kind.stiffness},
                                                   {"resistance", kind.resistance},
                                                   {"bed stiffness", kind.bed_stiffness},
                                                   {"bed resistance", kind.bed_resistance},
                                                   {"shear", kind.shear}};
  for (const auto& [what, value] : others) {
    if (finite_and_not_negative(value)) continue;
    throw core::InputError(
        fmt::format("support: the {} must be finite and not negative, not {}", what, value));
  }
}

Eigen::MatrixXd contact_factor(const solvers::modes::Modes& modes,
                               std::span<const Contact> contacts, double friction,
                               const surface::RigidBody* rigid) {
  check_support({.name = "", .friction = friction});
  const Eigen::Index directions = friction > 0 ? 3 : 1;
  const auto n = static_cast<Eigen::Index>(modes.size());
  const Eigen::Index rows = n + (rigid != nullptr ? 6 : 0);
  Eigen::MatrixXd columns(rows, directions * static_cast<Eigen::Index>(contacts.size()));
  Eigen::Index column = 0;
  for (const Contact& contact : contacts) {
    if (!(std::abs(contact.normal.norm() - 1) <= 1e-6)) {
      throw core::InputError(fmt::format(
          "support: the normal must be a unit vector, its length is {}", contact.normal.norm()));
    }
    if (!finite_and_not_negative(contact.fraction)) {
      throw core::InputError(
          fmt::format("support: a contact's fraction of the force must not be negative, not {}",
                      contact.fraction));
    }
    Eigen::MatrixX3d shapes(rows, 3);
    shapes.topRows(n) = modal::shapes_at(modes, contact.point);
    if (rigid != nullptr) {
      shapes.bottomRows<6>() =
          surface::rigid_shapes_at(*rigid, modal::frame_at(modes.surface, contact.point).position);
    }
    shapes *= std::sqrt(contact.fraction);
    columns.col(column++) = shapes * contact.normal;
    if (directions == 1) continue;
    const Vec3 side = contact.normal.unitOrthogonal();
    columns.col(column++) = std::sqrt(friction) * (shapes * side);
    columns.col(column++) = std::sqrt(friction) * (shapes * contact.normal.cross(side));
  }
  if (columns.cols() <= rows || rows == 0) return columns;
  // With L^T = Q R, L L^T = R^T R: as many columns as rows say the same.
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns.transpose());
  return Eigen::MatrixXd(qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>()).transpose();
}

Eigen::MatrixXd dashpots(const Eigen::MatrixXd& unit, double coefficient, double force) {
  check_press(coefficient, force, unit.squaredNorm());
  return (std::sqrt(coefficient) * std::sqrt(force)) * unit;
}

void add_support_damping(std::vector<double>& decay_rates, const Eigen::VectorXd& unit_diagonal,
                         double coefficient, double force) {
  if (unit_diagonal.size() != static_cast<Eigen::Index>(decay_rates.size())) {
    throw core::InputError(fmt::format("support: damping of {} modes for {} decay rates",
                                       unit_diagonal.size(), decay_rates.size()));
  }
  check_press(coefficient, force, unit_diagonal.sum());
  for (std::size_t i = 0; i < decay_rates.size(); ++i) {
    decay_rates[i] += coefficient * force * unit_diagonal[static_cast<Eigen::Index>(i)] / 2;
  }
}

double weight(const solvers::modes::Modes& modes) {
  return modes.mass * standard_gravity;
}

}  // namespace carillon::synth::support
