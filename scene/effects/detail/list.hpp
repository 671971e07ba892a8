#pragma once

#include "scene/effect.hpp"

namespace carillon::scene {

/// Each is defined in the file of its name; effects.cpp puts them in order.
extern const Effect damping_effect;
extern const Effect contact_effect;
extern const Effect striker_effect;
extern const Effect radiation_effect;
extern const Effect recording_effect;
extern const Effect noise_effect;
extern const Effect supports_effect;
extern const Effect click_effect;
extern const Effect room_effect;
extern const Effect tail_effect;
extern const Effect response_effect;
extern const Effect motion_effect;
extern const Effect lasting_contacts_effect;
extern const Effect contact_damping_effect;
extern const Effect touch_effect;
extern const Effect movie_effect;
extern const Effect mel_effect;
extern const Effect voxels_effect;
extern const Effect frames_effect;

}  // namespace carillon::scene
