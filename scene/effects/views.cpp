#include "scene/effects/detail/list.hpp"
#include "scene/picture.hpp"
#include "scene/scene.hpp"

namespace carillon::scene {

namespace {

constexpr const char* mel_key = "mel";
constexpr const char* voxels_key = "voxels";
constexpr const char* camera_key = "camera";

/// Asked for by a mapping of its own; the build reads that and makes the view.
template <const char* const& key>
SceneEffect read(core::ConfigNode& root, const Scene&) {
  SceneEffect effect;
  const std::string name = key;
  if (root.has(name)) {
    effect.asked_by = name + ": (" + root.where(name) + ")";
    if (key == camera_key) {
      effect.check = [root, name] { require_pictures(root, name, frames_effect.name); };
    }
  } else {
    effect.reason_off = "no " + name + ":";
  }
  return effect;
}

}  // namespace

const Effect mel_effect = {.name = "mel",
                           .description = "mel power spectrograms",
                           .key = "mel",
                           .stage = "view",
                           .read = read<mel_key>};
const Effect voxels_effect = {.name = "voxels",
                              .description = "voxel grid of each object",
                              .key = "voxels",
                              .stage = "view",
                              .read = read<voxels_key>};
const Effect frames_effect = {.name = "frames",
                              .description = "picture of each object",
                              .key = "camera",
                              .stage = "view",
                              .read = read<camera_key>};

}  // namespace carillon::scene
