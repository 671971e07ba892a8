#include "scene/effects/detail/list.hpp"

namespace carillon::scene {

std::span<const Effect> effects() {
  // What holds an object changes what it radiates; the recorder's shift comes before the noise,
  // which is there before the sound.
  static const Effect all[] = {damping_effect,
                               striker_effect,
                               contact_effect,
                               supports_effect,
                               radiation_effect,
                               click_effect,
                               room_effect,
                               tail_effect,
                               response_effect,
                               recording_effect,
                               noise_effect,
                               motion_effect,
                               lasting_contacts_effect,
                               contact_damping_effect,
                               touch_effect,
                               movie_effect,
                               mel_effect,
                               voxels_effect,
                               frames_effect};
  return all;
}

}  // namespace carillon::scene
