#include "synth/touch/stylus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace carillon::synth {

namespace {

constexpr double kMostTicks = 1e7;
constexpr double kLeastSteps = 8, kMostSteps = 512;  ///< of a tick
constexpr double kStepsPerTexel = 4;
/// Of the motion along the normal that is taken away where the face would feed energy.
constexpr double kHeldBack = 0.8;

void check(const Stylus& stylus, const solvers::TexturedFace& face, std::span<const Vec3> hand,
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
  Surface(const solvers::TexturedFace& face, double radius, TracedMaps& maps)
      : relief_(face.map->relief()),
        size_(face.size),
        traced_(maps.of(face.map, relief_ ? radius : 0)),
        map_(relief_ ? traced_->levels.front() : *face.map) {}

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
    plane.normal = solvers::normal_of(solvers::slope_at(map_, uv));
    plane.depth = height(uv) - tip.z();
    return plane;
  }
  double height(const Eigen::Vector2d& uv) const {
    return relief_ ? solvers::height_at(map_, uv) : 0.0;
  }
  /// How far a place lies above the lowest of what a normal map stands for [m].
  double virtual_height(const Eigen::Vector2d& uv) const {
    if (relief_) return 0;
    const solvers::SurfaceMap& heights = traced_->levels.front();
    const float lowest = *std::min_element(heights.heights.begin(), heights.heights.end());
    return solvers::height_at(heights, uv) - static_cast<double>(lowest);
  }

 private:
  bool relief_;
  Eigen::Vector2d size_;
  std::shared_ptr<const TracedMap> traced_;
  const solvers::SurfaceMap& map_;
};

/// The tip as a mass between hand and face.
class Tip {
 public:
  Tip(const Stylus& stylus, const Surface& surface, const Vec3& start, double allowance)
      : stylus_(stylus), surface_(surface), place_(start), given_(-allowance) {}

  /// @return the face's force
  Vec3 step(const Vec3& hand, const Vec3& hand_velocity, double h) {
    const Surface::Plane plane = surface_.under(place_);
    // Implicit in the tip's own motion: (m + h d + h^2 k) v1 = m v0 + h (forces at x0).
    const bool presses = stylus_.press > 0;
    const Vec3 springs(stylus_.hold, stylus_.hold, presses ? 0 : stylus_.hold);
    const Vec3 dampers(stylus_.hold_damping, stylus_.hold_damping,
                       presses ? 0 : stylus_.hold_damping);
    Vec3 forces = springs.cwiseProduct(hand - place_) + dampers.cwiseProduct(hand_velocity);
    forces.z() -= stylus_.press;
    const Vec3 inertia = Vec3::Constant(stylus_.mass) + h * dampers + h * h * springs;
    Vec3 velocity = (stylus_.mass * velocity_ + h * forces).cwiseQuotient(inertia);
    Vec3 force = Vec3::Zero();
    if (plane.there) {
      const double along = plane.normal.dot(velocity);
      const double gives = plane.normal.dot(plane.normal.cwiseQuotient(inertia));
      // k D / n_z at the depth D - (n . v1) h / n_z at the step's end.
      const double steep = plane.normal.z();
      const double spring = stylus_.stiffness / steep;
      const double both = spring / steep * h + stylus_.damping;
      const bool beneath = plane.depth * steep - h * along > 0;
      const double push =
          beneath ? std::max(0.0, (spring * plane.depth - both * along) / (1 + both * h * gives))
                  : 0.0;
      force = push * plane.normal;
      velocity += h * force.cwiseQuotient(inertia);
      rub(plane.normal, push * h, inertia, velocity, force, h);
      const double work = force.dot(velocity) * h;
      if (work > 0 && given_ + work > 0) {
        velocity -= kHeldBack * plane.normal.dot(velocity) * plane.normal;
        held_back = true;
      }
      given_ += force.dot(velocity) * h;
      fed_energy = std::max(fed_energy, given_);
    }
    velocity_ = velocity;
    place_ += h * velocity;
    return force;
  }

  const Vec3& place() const { return place_; }
  double speed() const { return velocity_.norm(); }

  double fed_energy = 0;
  bool held_back = false;

 private:
  /// Friction stops what moves along the plane, at most by mu times the normal impulse.
  void rub(const Vec3& normal, double impulse, const Vec3& inertia, Vec3& velocity, Vec3& force,
           double h) const {
    if (!(stylus_.friction > 0) || !(impulse > 0)) return;
    const Vec3 along = velocity - normal.dot(velocity) * normal;
    const double speed = along.norm();
    if (!(speed > 0)) return;
    const double stopping = speed * inertia.minCoeff();
    const Vec3 rubbing = -std::min(stopping, stylus_.friction * impulse) / speed * along;
    velocity += rubbing.cwiseQuotient(inertia);
    force += rubbing / h;
  }

  const Stylus& stylus_;
  const Surface& surface_;
  Vec3 place_;
  Vec3 velocity_ = Vec3::Zero();
  double given_;  ///< by the face, beyond what it may give [J]
};

Eigen::Matrix3d axes_of(const solvers::TexturedFace& face) {
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
  if (!(ticks <= kMostTicks)) {
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
    const double share = whole > 0 ? std::min(1.0, (way - ways[piece]) / whole) : 0;
    path.push_back(corners[piece] + share * (corners[piece + 1] - corners[piece]));
  }
  return path;
}

Touch draw_stylus(const solvers::TexturedFace& face, std::span<const Vec3> hand,
                  const Stylus& stylus, const TouchOptions& options) {
  check(stylus, face, hand, options);
  TracedMaps own;
  const Surface surface(face, stylus.radius, options.traced ? *options.traced : own);
  const Eigen::Matrix3d axes = axes_of(face);
  const auto to_face = [&](const Vec3& point) -> Vec3 {
    return axes.transpose() * (point - face.origin);
  };
  Vec3 start = to_face(hand[0]);
  start.z() = std::max(start.z(), surface.height(start.head<2>()));
  Tip tip(stylus, surface, start, stylus.press * surface.virtual_height(start.head<2>()));
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
    const double steps =
        std::clamp(std::ceil(kStepsPerTexel * way / face.map->texel), kLeastSteps, kMostSteps);
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
  touch.fed_energy = tip.fed_energy;
  return touch;
}

Motion motion_of(const Touch& touch, const solvers::TexturedFace& face) {
  Motion motion;
  motion.step = 1 / touch.rate;
  motion.left.assign(2, std::numeric_limits<double>::infinity());
  const Vec3 normal = face.normal();
  const std::size_t ticks = touch.tip.size();
  const auto velocity = [&](std::size_t tick) -> Vec3 {
    if (tick + 1 >= ticks) return Vec3::Zero();
    return (touch.tip[tick + 1] - touch.tip[tick]) * touch.rate;
  };
  bool touching = false;
  for (std::size_t tick = 0; tick < ticks; ++tick) {
    std::vector<BodyState> states(2);
    states[0].pose.origin = touch.tip[tick];
    states[0].velocity = velocity(tick);
    motion.states.push_back(std::move(states));
    if (tick + 1 == ticks) break;
    const double push = touch.forces[tick].dot(normal);
    if (!(push > 0)) {
      touching = false;
      continue;
    }
    if (!touching) {
      LastingContact contact;
      contact.bodies = {0, 1};
      contact.first_step = tick;
      motion.contacts.push_back(contact);
    }
    touching = true;
    ContactStep step;
    step.points = {Vec3(Vec3::Zero()), touch.tip[tick]};
    step.normal = normal;
    step.force = touch.forces[tick];
    step.slip = velocity(tick) - velocity(tick).dot(normal) * normal;
    step.sweep = {Vec3(Vec3::Zero()), step.slip};
    motion.contacts.back().steps.push_back(step);
  }
  return motion;
}

MovingBody moving_stylus(const Stylus& stylus) {
  MovingBody body;
  body.name = "stylus";
  body.rigid.mass = stylus.mass;
  body.ball_radius = stylus.radius;
  body.friction = stylus.friction;
  return body;
}

}  // namespace carillon::synth
