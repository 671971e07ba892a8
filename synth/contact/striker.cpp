#include "synth/contact/striker.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/units.hpp"

namespace carillon::synth::contact {

namespace {

using std::numbers::pi;

/// A hollow tighter than the striker is met as if 1/R were this fraction of the striker's.
constexpr double tightest_hollow = 0.1;

double positive(double value, const char* what) {
  if (!(value > 0)) {
    throw core::InputError(fmt::format("striker: {} must be positive, not {}", what, value));
  }
  return value;
}

/// (1 - nu^2) / E.
double compliance(double youngs_modulus, double poisson_ratio) {
  return (1 - poisson_ratio * poisson_ratio) / youngs_modulus;
}

Striker ball(std::string name, const material::Material& material, double radius,
             double restitution, std::string source) {
  return {std::move(name),
          ball_mass(radius, material.elastic.density),
          radius,
          material.elastic.youngs_modulus,
          material.elastic.poisson_ratio,
          restitution,
          std::move(source),
          material.elastic.density};
}

}  // namespace

double ball_mass(double radius, double density) {
  return density * 4 * pi / 3 * radius * radius * radius;
}

const std::vector<Striker>& preset_strikers() {
  static const std::vector<Striker> presets = {
      ball("metal", material::parse_material("steel"), 0.008, 0.7,
           "ball of the preset steel; radius and restitution assumed"),
      ball("wood", material::parse_material("wood"), 0.012, 0.5,
           "ball of the preset wood, taken as isotropic; radius and restitution assumed"),
      {"rubber", ball_mass(0.012, 1100), 0.012, 5e6, 0.49, 0.6,
       "ball of soft rubber of 5 MPa and 1100 kg/m^3; all values assumed", 1100},
      {"finger", 0.02, 0.008, 1e5, 0.49, 0.2,
       "fingertip with 20 g of finger behind it, pulp of 100 kPa; all values assumed"},
  };
  return presets;
}

const Striker& preset_striker(const std::string& name) {
  std::vector<std::string> names;
  for (const Striker& striker : preset_strikers()) {
    if (striker.name == name) return striker;
    names.push_back(striker.name);
  }
  const std::string nearest = core::nearest_name(name, names);
  throw core::InputError(fmt::format("no striker \"{}\"", name),
                         nearest.empty() ? "there are metal, wood, rubber and finger"
                                         : fmt::format("did you mean \"{}\"?", nearest));
}

void check_striker(const Striker& striker) {
  positive(striker.mass, "mass");
  positive(striker.radius, "radius");
  positive(striker.youngs_modulus, "Young's modulus");
  if (!(striker.poisson_ratio > -1 && striker.poisson_ratio <= 0.5)) {
    throw core::InputError(fmt::format(
        "striker: Poisson's ratio must lie between -1 and 0.5, not {}", striker.poisson_ratio));
  }
  if (!(striker.restitution >= 0 && striker.restitution <= 1)) {
    throw core::InputError(
        fmt::format("striker: restitution must lie between 0 and 1, not {}", striker.restitution));
  }
}

double mean_curvature(const solvers::modes::ModeSurface& surface,
                      const modal::SurfacePoint& point) {
  modal::frame_at(surface, point);  // refuses what is no point of a face
  // Over half the face: an interpolated sphere's own second derivatives waver by a quarter.
  constexpr double step_length = 0.25;
  const auto frame = [&](double first, double second) {
    return modal::frame_at(
        surface,
        {point.face, Eigen::Vector3d(1.0 / 3 - first - second, 1.0 / 3 + first, 1.0 / 3 + second)});
  };
  const modal::PointFrame right = frame(step_length, 0), left = frame(-step_length, 0);
  const modal::PointFrame up = frame(0, step_length), down = frame(0, -step_length);
  Eigen::Matrix<double, 3, 2> tangents;
  tangents << right.position - left.position, up.position - down.position;
  Eigen::Matrix<double, 3, 2> turns;
  turns << right.normal - left.normal, up.normal - down.normal;
  const Eigen::Matrix2d metric = tangents.transpose() * tangents;
  if (!(metric.determinant() > 1e-20 * metric.squaredNorm())) return 0;  // a face without area
  // dn = S dx on the surface: the trace of S is the sum of the principal curvatures.
  const Eigen::Matrix2d shape = metric.inverse() * (tangents.transpose() * turns);
  const double curvature = shape.trace() / 2;
  return std::isfinite(curvature) ? curvature : 0;
}

double hertz_constant() {
  // Integral of dx / sqrt(1 - x^(5/2)) from 0 to 1 is 2/5 B(2/5, 1/2).
  return 0.8 * std::pow(15.0 / 16, 0.4) * std::beta(0.4, 0.5);
}

HertzContact hertz_contact(const Striker& striker, const StruckBody& body, double speed) {
  check_striker(striker);
  positive(body.mass, "mass of the struck object");
  positive(body.youngs_modulus, "Young's modulus of the struck object");
  if (!(std::abs(body.poisson_ratio) <= 1) || !std::isfinite(body.curvature)) {
    throw core::InputError(
        fmt::format("striker: the struck object's Poisson's ratio {} or curvature "
                    "{} 1/m is not physical",
                    body.poisson_ratio, body.curvature));
  }
  if (!(speed >= 0) || !std::isfinite(speed)) {
    throw core::InputError(
        fmt::format("striker: the speed must be finite and not negative, not {} m/s", speed));
  }
  HertzContact contact;
  contact.mass = 1 / (1 / striker.mass + 1 / body.mass);
  contact.radius =
      1 / std::max(1 / striker.radius + body.curvature, tightest_hollow / striker.radius);
  contact.modulus = 1 / (compliance(striker.youngs_modulus, striker.poisson_ratio) +
                         compliance(body.youngs_modulus, body.poisson_ratio));
  if (!std::isfinite(contact.mass) || !(contact.mass > 0)) {
    throw core::InputError(
        fmt::format("striker: masses of {} and {} kg leave no finite mass in the contact",
                    striker.mass, body.mass),
        "give the striker a finite mass");
  }
  if (speed == 0) return contact;
  contact.impulse = contact.mass * speed * (1 + striker.restitution);
  if (!std::isfinite(contact.modulus)) {
    contact.peak_force = contact.modulus;
    return contact;
  }
  // Logarithms: powers of extreme values would overflow on the way.
  const double log_mass = std::log(contact.mass);
  const double log_radius = std::log(contact.radius);
  const double log_modulus = std::log(contact.modulus);
  const double log_speed = std::log(speed);
  contact.duration = hertz_constant() * std::exp(0.4 * log_mass - 0.2 * log_radius -
                                                 0.4 * log_modulus - 0.2 * log_speed);
  const double log_approach =
      0.4 * (std::log(15.0 / 16) + log_mass + 2 * log_speed - 0.5 * log_radius - log_modulus);
  contact.approach = std::exp(log_approach);
  contact.peak_force = 4.0 / 3 * std::exp(log_modulus + 0.5 * log_radius + 1.5 * log_approach);
  if (!std::isfinite(contact.duration) || !std::isfinite(contact.impulse)) {
    throw core::InputError(
        fmt::format("striker: a contact of {} s with an impulse of {} N s is beyond a double",
                    contact.duration, contact.impulse),
        "stiffen the striker or strike slower");
  }
  return contact;
}

}  // namespace carillon::synth::contact
