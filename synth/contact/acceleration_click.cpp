#include "synth/contact/acceleration_click.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/special_functions/ellint_rd.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "core/error.hpp"
#include "synth/modal/modal_response.hpp"
#include "synth/modal/sampled_force.hpp"
#include "synth/surface/outer_surface.hpp"

namespace carillon::synth::contact {

namespace {

using std::numbers::pi;

/// Time constants after which a free click is over: 1e-11 of it is left.
constexpr double free = 25;

/// The oscillator G / (a c^2) of a sphere under a force of unit impulse.
class SphereResponse {
 public:
  SphereResponse(double radius, const modal::ContactForce& force)
      : rate_(modal::speed_of_sound / radius), duration_(force.duration) {
    if (force.samples.empty()) {
      pulse_.emplace(2 * rate_ * rate_, rate_, duration_);
      decay_.emplace(2 * rate_ * rate_, rate_, pulse_->during_contact(duration_));
    } else {
      sampled_.emplace(2 * rate_ * rate_, rate_, force);
    }
  }

  /// q / (c r) + integral of q / r^2: the time integral of the pressure, but for a factor.
  double pressure_integral(double t, double distance) const {
    if (t < 0) return 0;
    const modal::ModalMotion motion = sampled_         ? sampled_->at(t)
                                      : t <= duration_ ? pulse_->during_contact(t)
                                                       : decay_->after_contact(t - duration_);
    // The equation of motion, integrated once.
    const double integral =
        (impulse(t) - motion.velocity - 2 * rate_ * motion.displacement) / (2 * rate_ * rate_);
    return motion.displacement / (modal::speed_of_sound * distance) +
           integral / (distance * distance);
  }
  /// After which the pressure is nil.
  double end() const { return duration_ + free / rate_; }

 private:
  double impulse(double t) const {
    if (sampled_) return sampled_->impulse(t);
    if (t >= duration_) return 1;
    return t / duration_ - std::sin(2 * pi * t / duration_) / (2 * pi);
  }

  double rate_;
  double duration_;
  std::optional<modal::ModalResponse> pulse_;
  std::optional<modal::ModalResponse> decay_;  ///< after it: the motion at its end is found once
  std::optional<modal::SampledResponse> sampled_;
};

void check(const RigidSource& source, const Vec3& impulse, const modal::ContactForce& force,
           const Vec3& listener, double sample_rate) {
  if (!impulse.allFinite() || !listener.allFinite()) {
    throw core::InputError("click: impulse or listener is not finite");
  }
  if (!(source.mass > 0) || !std::isfinite(source.mass) || !(source.radii.minCoeff() > 0) ||
      !source.radii.allFinite()) {
    throw core::InputError(
        fmt::format("click: an object of {} kg and equivalent radii {}, {}, {} m is not physical",
                    source.mass, source.radii[0], source.radii[1], source.radii[2]));
  }
  modal::check(force);
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw core::InputError(
        fmt::format("click: sample rate must be positive, not {} Hz", sample_rate));
  }
  if (!hears_click(source, listener)) {
    throw core::InputError(
        fmt::format(
            "click: the listener is {:.4g} m from the object's centre, inside the sphere of "
            "{:.4g} m that stands for it",
            (listener - source.centre).norm(), source.radii.maxCoeff()),
        "move the listener away from the object, or leave effects.click on auto or off");
  }
}

}  // namespace

Vec3 surface_ellipsoid(const solvers::modes::ModeSurface& surface, Eigen::Matrix3d* axes) {
  const std::vector<surface::SurfaceTriangle> triangles = surface::outer_pieces(surface);
  double area = 0;
  Vec3 moment = Vec3::Zero();
  for (const surface::SurfaceTriangle& triangle : triangles) {
    const auto& [a, b, c] = triangle.positions;
    const double own = surface::area_vector(triangle).norm();
    area += own;
    moment += own * (a + b + c) / 3;
  }
  if (!(area > 0)) throw core::InputError("click: the object has no outer surface");
  const Vec3 centre = moment / area;
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (const surface::SurfaceTriangle& triangle : triangles) {
    Eigen::Matrix3d x;
    for (int k = 0; k < 3; ++k) {
      x.col(k) = triangle.positions[static_cast<std::size_t>(k)] - centre;
    }
    const Vec3 sum = x.rowwise().sum();
    second +=
        surface::area_vector(triangle).norm() / 12 * (sum * sum.transpose() + x * x.transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(second / area);
  if (axes != nullptr) *axes = principal.eigenvectors();
  return (3 * principal.eigenvalues().cwiseMax(0)).cwiseSqrt();
}

Vec3 equivalent_radii(const Vec3& semi_axes) {
  const double longest = semi_axes.maxCoeff();
  // Flat bodies: the limit is reached long before, and R_D needs a finite thickness.
  const Vec3 a = (semi_axes / longest).cwiseMax(1e-6);
  const double product = a.prod();
  Vec3 alpha;
  for (int i = 0; i < 3; ++i) {
    const double others[2] = {a[(i + 1) % 3], a[(i + 2) % 3]};
    alpha[i] = 2.0 / 3 * product *
               boost::math::ellint_rd(others[0] * others[0], others[1] * others[1], a[i] * a[i]);
  }
  Vec3 radii;
  for (int i = 0; i < 3; ++i) {
    // The three alphas sum to 2: nothing cancels in 2 - alpha_i for flat bodies.
    const double volume = 4 * pi / 3 * product;
    const double moved = 2 * volume / (alpha[(i + 1) % 3] + alpha[(i + 2) % 3]);
    radii[i] = longest * std::cbrt(moved / (2 * pi));
  }
  return radii;
}

RigidSource rigid_source(const solvers::modes::ModeSurface& surface, double mass) {
  if (!(mass > 0) || !std::isfinite(mass)) {
    throw core::InputError(
        fmt::format("click: the object's mass must be positive, not {} kg", mass));
  }
  RigidSource source;
  source.mass = mass;
  source.centre = surface::outer_hull(surface).centroid;
  source.radii = equivalent_radii(surface_ellipsoid(surface, &source.axes));
  return source;
}

bool hears_click(const RigidSource& source, const Vec3& listener) {
  return (listener - source.centre).norm() >= source.radii.maxCoeff() * (1 - 1e-12);
}

std::vector<float> acceleration_click(const RigidSource& source, const Vec3& impulse,
                                      const modal::ContactForce& force, const Vec3& listener,
                                      double sample_rate, std::size_t count, double begin) {
  check(source, impulse, force, listener, sample_rate);
  if (!(begin >= 0) || !std::isfinite(begin)) {
    throw core::InputError(
        fmt::format("click: a strike must not begin before the clip, not at {} s", begin));
  }
  const Vec3 offset = listener - source.centre;
  const double distance = offset.norm();
  std::vector<double> pressure(count, 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const double along = source.axes.col(axis).dot(impulse);
    const double cosine = source.axes.col(axis).dot(offset) / distance;
    if (along == 0 || cosine == 0) continue;
    const double radius = source.radii[axis];
    const double mass = source.mass + modal::air_density * 2 * pi / 3 * radius * radius * radius;
    const double factor = modal::air_density * cosine * radius * modal::speed_of_sound *
                          modal::speed_of_sound * (along / mass) * sample_rate;
    const SphereResponse response(radius, force);
    const double delay = begin + std::max(0.0, distance - radius) / modal::speed_of_sound;
    const double first = std::ceil(delay * sample_rate);
    if (!(first < static_cast<double>(count))) continue;
    double before = 0;
    for (auto n = static_cast<std::size_t>(first); n < count; ++n) {
      const double t = static_cast<double>(n) / sample_rate - delay;
      const double integral = response.pressure_integral(std::max(0.0, t), distance);
      pressure[n] += factor * (integral - before);
      before = integral;
      if (t > response.end()) break;
    }
  }
  std::vector<float> result(count);
  for (std::size_t n = 0; n < count; ++n) {
    if (!(std::abs(pressure[n]) <= std::numeric_limits<float>::max())) {
      throw core::InputError(
          fmt::format("click: a pressure of {:.3g} Pa is beyond single precision", pressure[n]),
          "strike softer");
    }
    result[n] = static_cast<float>(pressure[n]);
  }
  return result;
}

}  // namespace carillon::synth::contact
