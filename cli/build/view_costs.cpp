#include "cli/build/view_costs.hpp"

#include <cmath>
#include <string_view>

namespace carillon::cli {

namespace {

// One core of a 2.3 GHz Xeon (docs/sound/speed.md).
constexpr double kSecondsPerWeight = 4.5e-10;  ///< of a band at a bin of a frame
constexpr double kSecondsPerPoint = 6e-9;      ///< of a frame's transform
constexpr double kSecondsPerCell = 2e-7;       ///< of a voxel grid, compression included
constexpr double kSecondsPerPixel = 2e-6;      ///< of a frame, likewise

double mel_seconds(const synth::MelOptions& mel, std::size_t samples) {
  const double frames = synth::mel_frames(samples, mel);
  const double bins = mel.fft_size / 2 + 1;
  return frames * (kSecondsPerWeight * mel.bands * bins + kSecondsPerPoint * mel.fft_size);
}

}  // namespace

void price_views(BuildConfig& config) {
  for (EffectDecision& decision : config.scene.effects) {
    SceneEffect& effect = decision.in_scene;
    const std::string_view name = decision.effect->name;
    if (name == "mel" && config.mel) {
      effect.seconds_per_sound = mel_seconds(*config.mel, config.scene.audio.samples());
    } else if (name == "voxels" && config.voxels) {
      effect.seconds_per_shape = kSecondsPerCell * std::pow(config.voxels->resolution, 3);
    } else if (name == "frames" && config.camera) {
      effect.seconds_per_shape = kSecondsPerPixel * config.camera->width * config.camera->height;
    }
  }
}

}  // namespace carillon::cli
