#include "cli/sound/effects/list.hpp"

namespace carillon::cli {

std::span<const Effect> effects() {
  static const Effect all[] = {damping_effect, contact_effect, radiation_effect,
                               mel_effect,     voxels_effect,  frames_effect};
  return all;
}

}  // namespace carillon::cli
