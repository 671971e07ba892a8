#pragma once

#include <span>

#include "synth/motion/motion.hpp"

namespace carillon::synth::motion {

/// Moves bodies under gravity and contact (Bullet, sequential impulses in double precision) by a
/// fixed step. The same input gives the same bits.
///
/// What Bullet is given beside its defaults, so that energy does not grow: penetration is undone by
/// positions alone (split impulses); contact begins at touch, not at a distance; a rebound has the
/// speed that the bodies had at the surfaces, restitution times that, although contact is found
/// some way below; below a few steps' worth of gravity there is no rebound. Time and speed of an
/// impact are those at the surface.
///
/// A step is cut into as many parts as keep every body from moving farther than half its own
/// thinnest half-extent (at most 64), so that nothing fast and thin passes through another.
///
/// Textures: on a normal map the normal of a contact on the textured face is that of the map, and a
/// ball's place of contact is moved to c - r n (dissertation 5.2.3, eq. 5.2). On a relief contacts
/// on the face are those of relief_contacts() (dissertation 5.3.1). When both bodies have a
/// texture, that of the first counts.
///
/// @throws InputError   values that are not finite or physical, bodies without hull, a string of no
///                      body; names the body
/// @throws core::Error  a state that is not finite; names body and time
Motion simulate_motion(std::span<const MovingBody> bodies, std::span<const MotionString> strings,
                       const MotionOptions& options);

/// Kinetic energy and that of height in gravity [J] of bodies that are not fixed.
double mechanical_energy(std::span<const MovingBody> bodies, std::span<const BodyState> states,
                         const Vec3& gravity);

}  // namespace carillon::synth::motion
