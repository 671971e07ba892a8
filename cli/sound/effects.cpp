#include "cli/sound/effects/list.hpp"

namespace carillon::cli {

std::span<const Effect> effects() {
  // The recorder's shift comes before the noise, which is there before the sound.
  static const Effect all[] = {damping_effect,  contact_effect,   radiation_effect,
                               supports_effect, recording_effect, noise_effect,
                               mel_effect,      voxels_effect,    frames_effect};
  return all;
}

}  // namespace carillon::cli
