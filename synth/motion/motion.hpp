#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/time_limit.hpp"
#include "render/maps/surface_map.hpp"
#include "synth/surface/rigid_body.hpp"

namespace carillon::synth::motion {

/// Where a body is: its own coordinates (those of its mesh) are turned, then moved.
struct Pose {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Vec3 origin = Vec3::Zero();  ///< of the body's coordinates [m]

  Vec3 to_world(const Vec3& point) const { return origin + turn * point; }
  Vec3 to_body(const Vec3& point) const { return turn.conjugate() * (point - origin); }
};

struct BodyState {
  Pose pose;
  Vec3 velocity = Vec3::Zero();  ///< of the centre of mass [m/s]
  Vec3 spin = Vec3::Zero();      ///< [rad/s], world axes
};

/// What the motion needs to know of a body.
struct MovingBody {
  std::string name;
  surface::RigidBody rigid;              ///< in the body's coordinates
  std::vector<std::vector<Vec3>> hulls;  ///< points of convex pieces, body's coordinates [m]
  double ball_radius =
      0;               ///< > 0: a ball of this radius about the centre of mass, in place of hulls
  double release = 0;  ///< held at its start until then [s]
  bool fixed = false;  ///< held where it is: of infinite mass
  double friction = 0.5;        ///< Coulomb's mu of a pair is sqrt(mu_a mu_b)
  double rolling_friction = 0;  ///< of a pair: sum [m], torque over normal force
  double restitution = 0.5;     ///< of a pair: sqrt(e_a e_b)
  double youngs_modulus = 0;    ///< [Pa]
  double poisson_ratio = 0;
  double curvature = 0;  ///< [1/m] of the rounded parts that strike; 0: flat (a ball: 1 / radius)
  std::optional<render::maps::TexturedFace> texture;
  BodyState start;
};

/// A string from a place of the world to a point of a body: it pulls when it is taut and never
/// pushes.
struct MotionString {
  std::size_t body = 0;
  Vec3 at = Vec3::Zero();      ///< body's coordinates [m]
  Vec3 anchor = Vec3::Zero();  ///< world [m]
  double length = 0;           ///< [m]; 0: as far as they are apart at the start
};

/// Into which a step is cut at the most.
inline constexpr int max_substep_count = 64;

struct MotionOptions {
  double seconds = 1;
  double time_step = 1e-3;  ///< [s]
  Vec3 gravity = {0, 0, -9.80665};
  double min_speed = 0.01;     ///< of approach that counts as a strike [m/s]
  double world_radius = 50;    ///< bodies farther than this from the origin have left [m]
  core::TimeLimit limit = {};  ///< asked after each step
};

/// A strike between two bodies.
struct Impact {
  double time = 0;                      ///< [s], within the step
  std::array<std::size_t, 2> bodies{};  ///< the first has the smaller number
  std::array<Vec3, 2> points;           ///< in each body's coordinates [m]
  Vec3 normal = Vec3::Zero();           ///< unit, world, from the second body into the first
  Vec3 impulse = Vec3::Zero();          ///< on the first body, world [N s], friction included
  double speed = 0;                     ///< of approach along the normal [m/s]
  double duration = 0;                  ///< of Hertz's contact [s]
};

/// One step of a contact that lasts.
struct ContactStep {
  std::array<Vec3, 2> points;  ///< in each body's coordinates [m]
  Vec3 normal = Vec3::Zero();  ///< unit, world, of the bodies' geometry (not of a texture), from
                               ///< the second body into the first
  Vec3 force = Vec3::Zero();   ///< on the first body, world, mean over the step [N]
  Vec3 slip = Vec3::Zero();    ///< velocity of the first body's point against the second's [m/s]
  /// Velocity at which the place of contact moves over each body's surface, world [m/s]. Their
  /// difference is the slip: a ball that rolls has the same on both.
  std::array<Vec3, 2> sweep;
};

/// Two bodies that stay in touch at a place: consecutive steps.
struct LastingContact {
  std::array<std::size_t, 2> bodies{};
  std::size_t first_step = 0;
  std::vector<ContactStep> steps;
};

/// Two bodies that are in one another at the start, and are pushed apart.
struct Overlap {
  std::array<std::size_t, 2> bodies{};  ///< the first has the smaller number
  double depth = 0;                     ///< [m]
};

/// What happened. State k is that at time k step.
struct Motion {
  double step = 0;
  std::vector<std::vector<BodyState>> states;  ///< [steps + 1][bodies]
  std::vector<Impact> impacts;                 ///< in order of time
  std::vector<LastingContact> contacts;        ///< in order of their begin
  std::vector<std::vector<double>> tensions;   ///< [steps][strings], mean over the step [N]
  std::vector<double> energy;                  ///< kinetic and potential [J], steps + 1 values
  int max_substeps = 1;  ///< into which a step was cut for bodies that are fast and thin
  /// When a body was first so fast and thin that max_substep_count were too few: things may then
  /// pass through one another [s].
  std::optional<double> too_fast;
  std::vector<Overlap> overlaps;  ///< of more than a thousandth of the smaller body
  std::vector<double> left;       ///< time at which each body left the world [s]; infinite: never
};

/// Where a body is at any time: between two states, as turned as far as time has gone.
Pose pose_at(const Motion& motion, std::size_t body, double time);

}  // namespace carillon::synth::motion
