#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dataset/exporters/gltf_audio.hpp"
#include "dataset/exporters/gltf_surface.hpp"
#include "render/frame.hpp"

namespace carillon::dataset::exporters {

/// What one region looks like.
struct GltfMaterial {
  std::string name;
  render::Appearance appearance;
};

/// A mode that a file shows.
struct GltfMode {
  std::string name;
  double frequency = 0;  ///< undamped [Hz]
  GltfTarget target;
  nlohmann::ordered_json facts;  ///< for `extras`
};

/// Everything that a file of one object holds.
struct GltfObject {
  std::string name;
  GltfSurface surface;
  std::vector<GltfMaterial> materials;  ///< one for each region
  std::vector<GltfMode> modes;
  std::optional<GltfAudio> audio;  ///< its sound, as KHR_audio_rigid_bodies
  double period = 1;               ///< of each mode's animation [s]
  nlohmann::ordered_json facts;    ///< for the mesh's `extras`
};

/// A binary glTF 2.0 file: one mesh, a primitive for each region, a morph target and an animation
/// for each mode that is shown, and a modal model of those that sound.
/// @throws InputError  more than 4 GiB
std::string gltf_bytes(const GltfObject& object);

}  // namespace carillon::dataset::exporters
