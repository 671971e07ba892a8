#include "cli/sound/effects/list.hpp"
#include "cli/sound/scene.hpp"

namespace carillon::cli {

namespace {

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  if (scene.listeners.empty()) {
    effect.reason_off = "no listener: the dry signal is the velocity of the struck point";
  } else {
    effect.asked_by = "listeners: (" + root.where("listeners") + ")";
  }
  effect.start = [](const std::filesystem::path&) {
    EffectParts parts;
    parts.body = [](RingingBody& body) {
      body.pressure = synth::monopole(*body.modes, body.listeners);
    };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect radiation_effect = {
    .name = "radiation",
    .description = "sound pressure at listeners from the body's volume velocity (monopole)",
    .read = read};

}  // namespace carillon::cli
