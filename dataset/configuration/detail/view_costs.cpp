#include "dataset/configuration/detail/view_costs.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace carillon::dataset::configuration {

namespace {

// One core of a 2.3 GHz Xeon (docs/sound/speed.md).
constexpr double seconds_per_weight = 4.5e-10;  ///< of a band at a bin of a frame
constexpr double seconds_per_point = 6e-9;      ///< of a frame's transform
constexpr double seconds_per_cell = 2e-7;       ///< of a voxel grid, compression included
constexpr double seconds_per_pixel = 2e-6;      ///< of a frame, likewise

double mel_seconds(const synth::signal::MelOptions& mel, std::size_t samples) {
  const double frames = 1 + static_cast<double>(samples) / mel.hop;
  const double bins = mel.fft_size / 2 + 1;
  return frames * (seconds_per_weight * mel.bands * bins + seconds_per_point * mel.fft_size);
}

// One core of a 2.3 GHz Xeon (docs/scenes.md).
constexpr double seconds_per_body_step = 2e-5;       ///< of a motion, where a body meets another
constexpr double seconds_per_contact_sample = 1e-7;  ///< of each body, contacts coming and going
constexpr double seconds_per_tick = 2e-6;            ///< of a stylus
constexpr double seconds_per_scene_pixel = 1.5e-6;   ///< of a moving scene's frame

/// Of a simulation, whatever its listeners.
double motion_seconds(const BuildConfig& config, std::string_view effect) {
  const scene::motion::MotionConfig& motion = *config.motion;
  const scene::AudioConfig& audio = config.scene.audio;
  const double steps = audio.seconds / motion.options.time_step;
  const auto bodies = static_cast<double>(motion.bodies.size());
  if (effect == "motion") return seconds_per_body_step * bodies * steps;
  if (effect == "lasting_contacts") {
    return seconds_per_contact_sample * bodies * static_cast<double>(audio.samples());
  }
  if (effect == "touch") return seconds_per_tick * steps;
  if (effect == "movie" && motion.camera) {
    return seconds_per_scene_pixel * motion.camera->pixels(audio.seconds);
  }
  return 0;
}

/// Of the maps that a task keeps as tips trace them: a map's levels for each textured body.
double traced_bytes(const scene::motion::MotionConfig& motion) {
  constexpr double levels = 10, image_side = 1024;
  double texels = 0;
  const auto add = [&](const std::optional<scene::motion::TextureConfig>& texture) {
    if (!texture) return;
    const double side = texture->map.empty() ? image_side : texture->texels;
    texels += levels * side * side;
  };
  for (const scene::motion::CastBody& body : motion.bodies) add(body.texture);
  if (motion.ground) add(motion.ground->texture);
  return sizeof(float) * std::min(texels, static_cast<double>(synth::motion::max_traced_texels));
}

/// Materials that an object sounds in, in the mean over the entries of `objects`.
double pictured_materials(const BuildConfig& config) {
  double sum = 0;
  for (const ObjectSource& source : config.objects)
    sum += static_cast<double>(sounding_materials(config, source));
  return sum / static_cast<double>(config.objects.size());
}

}  // namespace

void price_views(BuildConfig& config) {
  for (scene::EffectDecision& decision : config.scene.effects) {
    scene::SceneEffect& effect = decision.in_scene;
    const std::string_view name = decision.effect->name;
    if (name == "mel" && config.mel) {
      effect.seconds_per_sound = mel_seconds(*config.mel, config.scene.audio.samples());
    } else if (name == "voxels" && config.voxels) {
      effect.seconds_per_shape =
          seconds_per_cell * config.voxels->turns * std::pow(config.voxels->resolution, 3);
    } else if (name == "frames") {
      const double materials = pictured_materials(config);
      for (const render::Camera& camera : config.cameras)
        effect.seconds_per_shape += materials * seconds_per_pixel * camera.width * camera.height;
    } else if (name == "lasting_contacts" && config.motion) {
      effect.memory = traced_bytes(*config.motion);
      effect.seconds_by_modes = [seconds = motion_seconds(config, name)](int) { return seconds; };
    } else if (config.motion && decision.effect->stage == std::string_view("motion")) {
      effect.seconds_by_modes = [seconds = motion_seconds(config, name)](int) { return seconds; };
    }
  }
}

}  // namespace carillon::dataset::configuration
