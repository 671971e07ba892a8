#include "synth/touch/stylus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::synth::touch {

namespace {

constexpr double max_ticks = 1e7;
constexpr double steps_per_second = 8000;  ///< at least; springs of 50 kN/m take 4 ms a swing
constexpr double max_steps = 512;          ///< of a tick
constexpr double steps_per_texel = 4;
/// A tick is held back where the spring is compressed by less than this fraction of the tip's
/// depth.
constexpr double held_fraction = 0.9;

void check(const Stylus& stylus, const render::maps::TexturedFace& face, std::span<const Vec3> hand,
           const TouchOptions& options) {
  const double positive[] = {stylus.mass, stylus.hold, stylus.stiffness, stylus.largest_force,
                             options.rate};
  const double others[] = {stylus.radius, stylus.hold_damping, stylus.press, stylus.damping,
                           stylus.friction};
  const bool fine = std::all_of(std::begin(positive), std::end(positive),
                                [](double value) { return value > 0 && std::isfinite(value); }) &&
                    std::all_of(std::begin(others), std::end(others),
                                [](double value) { return value >= 0 && std::isfinite(value); });
  if (!fine) {
    throw core::InputError(
        "stylus: mass, springs, largest force and rate must be positive, damping, press, friction "
        "and radius not negative, and all of them finite");
  }
  if (face.map == nullptr) throw core::InputError("stylus: the face has no map");
  if (!(face.size.minCoeff() > 0) || !(std::abs(face.u.dot(face.v)) < 1e-6)) {
    throw core::InputError("stylus: the face has no size, or axes that are not at right angles");
  }
  if (hand.empty()) throw core::InputError("stylus: the path has no positions");
  for (std::size_t k = 0; k < hand.size(); ++k) {
    if (hand[k].allFinite()) continue;
    throw core::InputError(fmt::format("stylus: the path is not finite at tick {} ({:.4g} s)", k,
                                       static_cast<double>(k) / options.rate),
                           "give positions in metres that are numbers");
  }
}

/// The map as the tip meets it, in the face's coordinates (u, v, height).
class Surface {
 public:
  Surface(const render::maps::TexturedFace& face, double radius, motion::TracedMaps& maps)
      : relief_(face.map->relief()),
        size_(face.size),
        traced_(maps.finest(face.map, relief_ ? radius : 0)),
        map_(relief_ ? *traced_ : *face.map) {
    const std::vector<float>& heights = traced_->heights;
    lowest_ = static_cast<double>(*std::min_element(heights.begin(), heights.end()));
  }

  struct Plane {
    bool there = false;
    Vec3 normal;
    double depth = 0;  ///< of the tip beneath its point, along the face's normal [m]
  };
  Plane under(const Vec3& tip) const {
    Plane plane;
    const Eigen::Vector2d uv = tip.head<2>();
    if (uv.minCoeff() < 0 || (size_ - uv).minCoeff() < 0) return plane;
    plane.there = true;
    plane.normal = render::maps::normal_of(render::maps::slope_at(map_, uv));
    plane.depth = height(uv) - tip.z();
    return plane;
  }
  double height(const Eigen::Vector2d& uv) const {
    return relief_ ? render::maps::height_at(map_, uv) : 0.0;
  }
  /// Of what a normal map stands for, above its lowest texel [m]; a relief stands for nothing.
  double virtual_height(const Eigen::Vector2d& uv) const {
    return relief_ ? 0 : render::maps::height_at(*traced_, uv) - lowest_;
  }
  bool relief() const { return relief_; }

 private:
  bool relief_;
  Eigen::Vector2d size_;
  motion::SharedMap traced_;
  const render::maps::SurfaceMap& map_;
  double lowest_ = 0;
};

/// The tip as a mass between hand and face.
class Tip {
 public:
  Tip(const Stylus& stylus, const Surface& surface, const Vec3& start)
      : stylus_(stylus), surface_(surface), place_(start) {}

  /// @return the face's force
  Vec3 step(const Vec3& hand, const Vec3& hand_velocity, double h) {
    const Surface::Plane plane = surface_.under(place_);
    // Beside the face there is nothing to press on, and a hand does not fall through the air.
    const bool presses = stylus_.press > 0 && plane.there;
    const Vec3 springs(stylus_.hold, stylus_.hold, presses ? 0 : stylus_.hold);
    const Vec3 dampers(stylus_.hold_damping, stylus_.hold_damping,
                       presses ? 0 : stylus_.hold_damping);
    // Implicit in the tip's own motion: (m + h d + h^2 k) v1 = m v0 + h (forces at x0).
    Vec3 forces = springs.cwiseProduct(hand - place_) + dampers.cwiseProduct(hand_velocity);
    if (presses) forces.z() -= stylus_.press;
    const Vec3 inertia = Vec3::Constant(stylus_.mass) + h * dampers + h * h * springs;
    Vec3 velocity = (stylus_.mass * velocity_ + h * forces).cwiseQuotient(inertia);
    Vec3 force = Vec3::Zero();
    if (plane.there) {
      const double pressed =
          presses ? stylus_.press : std::max(0.0, stylus_.hold * (place_.z() - hand.z()));
      const double depth = compressed(plane, pressed * surface_.virtual_height(place_.head<2>()));
      const double push = push_of(plane, depth, plane.normal.dot(velocity), inertia, h);
      force = push * plane.normal;
      velocity += h * force.cwiseQuotient(inertia);
      rub(plane.normal, push * h, inertia, velocity, force, h);
      // On a relief the spring alone has a potential, and is counted without the damper.
      const double outward = plane.normal.dot(velocity);
      const double damper = push > 0 && surface_.relief() ? stylus_.damping * outward : 0;
      may_give_ -= std::max(0.0, push + damper) * outward * h;
    }
    velocity_ = velocity;
    place_ += h * velocity;
    return force;
  }

  const Vec3& place() const { return place_; }
  double speed() const { return velocity_.norm(); }

  bool held_back = false;

 private:
  /// How far the face's spring is compressed: by the tip's depth, but no further than what it took
  /// compresses it. So it cannot give more, and what it took beyond its potential is lost.
  /// @param virtual_potential  of the heights that a normal map stands for [J]
  double compressed(const Surface::Plane& plane, double virtual_potential) {
    if (!came_) may_give_ = virtual_potential;
    came_ = true;
    const double depth = std::max(0.0, plane.depth);
    may_give_ = std::min(may_give_, stylus_.stiffness * depth * depth / 2 + virtual_potential);
    const double paid = std::sqrt(2 * std::max(0.0, may_give_) / stylus_.stiffness);
    held_back = held_back || paid < held_fraction * depth;
    return std::min(plane.depth, paid);
  }

  /// What spring and damper of the face push the tip with along the plane's normal [N].
  /// @param outward  speed along the normal at the step's end, without them
  double push_of(const Surface::Plane& plane, double depth, double outward, const Vec3& inertia,
                 double h) const {
    const double steep = plane.normal.z();
    if (!(depth * steep - h * outward > 0)) return 0;
    const double gives = plane.normal.dot(plane.normal.cwiseQuotient(inertia));
    // k D / n_z at the depth D - (n . v1) h / n_z at the step's end.
    const double spring = stylus_.stiffness / steep;
    const double both = spring / steep * h + stylus_.damping;
    return std::max(0.0, (spring * depth - both * outward) / (1 + both * h * gives));
  }

  /// Friction stops what moves along the plane, at most by mu times the normal impulse.
  void rub(const Vec3& normal, double impulse, const Vec3& inertia, Vec3& velocity, Vec3& force,
           double h) const {
    if (!(stylus_.friction > 0) || !(impulse > 0)) return;
    const Vec3 along = velocity - normal.dot(velocity) * normal;
    const double speed = along.norm();
    if (!(speed > 0)) return;
    // The impulse that changes this velocity alone: were the one along the normal disturbed, a
    // tip at rest on a slope would creep.
    const Vec3 way = along / speed;
    const Vec3 whole = inertia.cwiseProduct(way);
    const double stopped = std::min(speed, stylus_.friction * impulse / way.dot(whole));
    velocity -= stopped * way;
    force -= stopped / h * whole;
  }

  const Stylus& stylus_;
  const Surface& surface_;
  Vec3 place_;
  Vec3 velocity_ = Vec3::Zero();
  double may_give_ = 0;  ///< the face, from here on [J]
  bool came_ = false;    ///< the tip, to the face
};

Eigen::Matrix3d axes_of(const render::maps::TexturedFace& face) {
  Eigen::Matrix3d axes;
  axes << face.u, face.v, face.normal();
  return axes;
}

}  // namespace

std::vector<Vec3> drawn_path(std::span<const Vec3> corners, double speed, double rate) {
  if (corners.empty()) throw core::InputError("stylus: the path has no corners");
  if (!(speed > 0) || !std::isfinite(speed) || !(rate > 0) || !std::isfinite(rate)) {
    throw core::InputError(fmt::format(
        "stylus: a path is drawn at a positive speed and rate, not {} m/s and {} Hz", speed, rate));
  }
  double length = 0;
  std::vector<double> ways = {0};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    if (!corners[k].allFinite()) {
      throw core::InputError(fmt::format("stylus: corner {} of the path is not finite", k),
                             "give positions in metres that are numbers");
    }
    if (k > 0) ways.push_back(length += (corners[k] - corners[k - 1]).norm());
  }
  const double ticks = length / speed * rate;
  if (!(ticks <= max_ticks)) {
    throw core::InputError(
        fmt::format("stylus: a path of {:.4g} m at {:.4g} m/s takes {:.3g} ticks", length, speed,
                    ticks),
        "draw faster, or a shorter way");
  }
  std::vector<Vec3> path;
  std::size_t piece = 0;
  for (double tick = 0; tick <= ticks; ++tick) {
    const double way = tick * speed / rate;
    while (piece + 2 < corners.size() && ways[piece + 1] <= way) ++piece;
    if (corners.size() == 1) {
      path.push_back(corners[0]);
      continue;
    }
    const double whole = ways[piece + 1] - ways[piece];
    const double fraction = whole > 0 ? std::min(1.0, (way - ways[piece]) / whole) : 0;
    path.push_back(corners[piece] + fraction * (corners[piece + 1] - corners[piece]));
  }
  // The rest of a tick's way, to the end itself.
  if (ticks - std::floor(ticks) > 1e-6) path.push_back(corners.back());
  return path;
}

Touch draw_stylus(const render::maps::TexturedFace& face, std::span<const Vec3> hand,
                  const Stylus& stylus, const TouchOptions& options) {
  check(stylus, face, hand, options);
  motion::TracedMaps own;
  const Surface surface(face, stylus.radius, options.traced ? *options.traced : own);
  const Eigen::Matrix3d axes = axes_of(face);
  const auto to_face = [&](const Vec3& point) -> Vec3 {
    return axes.transpose() * (point - face.origin);
  };
  Vec3 start = to_face(hand[0]);
  if (surface.under(start).there) {
    start.z() = std::max(start.z(), surface.height(start.head<2>()));
  }
  Tip tip(stylus, surface, start);
  Touch touch;
  touch.rate = options.rate;
  for (std::size_t tick = 0; tick < hand.size(); ++tick) {
    const Vec3 from = to_face(hand[tick]);
    const Vec3 to = to_face(hand[std::min(tick + 1, hand.size() - 1)]);
    touch.hand.push_back(hand[tick]);
    touch.tip.push_back(face.origin + axes * tip.place());
    // What the tip may go this tick.
    const double gains = stylus.press / stylus.mass / options.rate;
    const double way = (to - from).norm() + (tip.speed() + gains) / options.rate;
    const double steps = std::clamp(std::ceil(std::max(steps_per_texel * way / face.map->texel,
                                                       steps_per_second / options.rate)),
                                    1.0, max_steps);
    const double h = 1 / (options.rate * steps);
    const Vec3 velocity = (to - from) * options.rate;
    tip.held_back = false;
    Vec3 sum = Vec3::Zero();
    for (double step = 1; step <= steps; ++step) {
      sum += tip.step(from + step / steps * (to - from), velocity, h);
    }
    Vec3 force = axes * sum / steps;
    if (force.norm() > stylus.largest_force) {
      force *= stylus.largest_force / force.norm();
      ++touch.limited;
    }
    touch.forces.push_back(force);
    touch.held_back += tip.held_back ? 1 : 0;
  }
  return touch;
}

}  // namespace carillon::synth::touch
