#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <span>

#include "synth/motion/detail/collision_shape.hpp"
#include "synth/motion/detail/relief_peaks.hpp"

namespace carillon::synth::motion {

/// Contacts whose normal is nearer than this to a face's (cosine) are contacts on the face.
inline constexpr double on_face_limit = 0.7;

/// Contacts on textured faces as the textures have them (simulate_motion()); others stay.
/// @param shapes     of the bodies, whose numbers are the objects' user indices
/// @param peaks      of the bodies' reliefs, where they have one
/// @param principal  turns of the principal axes, as principal_turn()
/// @param unit       of Bullet's lengths [m]
void change_textured_contacts(btCollisionDispatcher& dispatcher, std::span<const MovingBody> bodies,
                              std::span<const CollisionShape> shapes,
                              std::span<const std::shared_ptr<const ReliefPeaks>> peaks,
                              std::span<const Eigen::Quaterniond> principal, double unit);

}  // namespace carillon::synth::motion
