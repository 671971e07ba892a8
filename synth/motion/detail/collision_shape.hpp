#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <span>
#include <vector>

#include "synth/motion/motion.hpp"

namespace carillon::synth::motion {

/// What Bullet collides, in the frame of the body's principal axes at its centre of mass, and what
/// it is made of.
struct CollisionShape {
  std::vector<std::unique_ptr<btCollisionShape>> parts;
  std::unique_ptr<btCollisionShape> whole;  ///< refers to the parts
  double skin = 0;                          ///< by which a box is larger than it is, all around [m]
  double thinnest = 0;                      ///< smallest half-extent of a piece [m]
  double reach = 0;                         ///< largest distance from the centre of mass [m]
  solvers::mesh::SurfaceMesh hull;  ///< of all pieces, for reliefs, in the body's coordinates [m]
};

/// A ball is a sphere, pieces that fill their box are boxes, others convex hulls.
/// @param unit  of Bullet's lengths [m]
/// @param skin  a body that is one box is given so much all around [m]: Bullet finds contacts of
///              boxes when they overlap, and of others when they are near
/// @throws InputError  no pieces, pieces without volume; names the body
CollisionShape collision_shape(const MovingBody& body, double unit, double skin);

/// Turns the principal axes' coordinates into the body's.
Eigen::Quaterniond principal_turn(const surface::RigidBody& rigid);

/// Longest distance from the centre of mass [m].
double reach_of(const MovingBody& body);

/// Median reach of what moves [m]; 1 where nothing does.
double median_reach(std::span<const MovingBody> bodies);

}  // namespace carillon::synth::motion
