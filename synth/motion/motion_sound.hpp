#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "synth/motion/effect_use.hpp"
#include "synth/motion/lasting_force.hpp"
#include "synth/motion/motion.hpp"
#include "synth/motion/sounding_body.hpp"

namespace carillon::synth::motion {

struct MotionSoundOptions {
  double sample_rate = 44100;  ///< [Hz]
  double seconds = 0;          ///< of the clip; 0: as long as the motion

  // What is heard.
  bool impacts = true;
  bool lasting_contacts = true;  ///< what rolls and scrapes
  bool contact_damping = true;   ///< contacts damp the modes while they last
  bool clicks = true;            ///< of bodies that have one, where there are listeners
  bool moving_radiation = true;  ///< poses and Doppler; false: all are heard from where they start

  bool hertz_pulses = false;     ///< the strikes' course; false: the raised cosine
  double turn = 0.05;            ///< between key poses of the radiation [rad]
  LastingForceOptions contacts;  ///< its sample rate is the clip's
  core::TimeLimit limit = {};    ///< asked after each body
};

struct MotionSound {
  std::size_t rows = 0;        ///< of each listener, or the one dry row
  std::vector<float> samples;  ///< row by row
  std::string unit;            ///< "Pa", or "m/s" (dry)

  EffectUse ringing;           ///< blocks of modes that were not at rest
  EffectUse impacts;           ///< strikes on bodies that sound: two for each impact
  EffectUse lasting_contacts;  ///< blocks in which a contact drove a body
  EffectUse contact_damping;   ///< blocks of contacts and strings that damped a body
  EffectUse clicks;            ///< of a strike at a listener
  EffectUse moving_radiation;  ///< poses at which gains were computed
  std::uint64_t mode_samples = 0;
};

/// What a motion sounds like.
///
/// Every impact strikes both of its bodies, with opposite impulses, at the surface's nearest points
/// and for Hertz's duration. Lasting contacts drive both (LastingForces). While a contact lasts it
/// damps the modes of its bodies by what they rest as: coefficient times normal force, at the
/// contact's place, step by step (the diagonal of contact_factor()); strings do so by their
/// tension. At listeners (world coordinates) gains follow the bodies' poses, and sounds arrive
/// after their time of flight from the body's centroid. Without listeners there is one dry row, the
/// sum of all bodies' mean_square_velocity(). Bodies do not shade or reflect each other's sound.
///
/// @param moving  bodies of the motion, as it moved them
/// @param bodies  the same as they sound: those without modes are silent
/// @throws InputError  sizes that do not match, a body without what its sound needs, a listener on
///                     or in a body, values that are not finite
MotionSound motion_sound(const Motion& motion, std::span<const MovingBody> moving,
                         std::span<const SoundingBody> bodies,
                         std::span<const modal::Listener> listeners,
                         const MotionSoundOptions& options);

}  // namespace carillon::synth::motion
