#include "cli/body.hpp"
#include "cli/sound/effects/list.hpp"
#include "cli/sound/scene.hpp"
#include "synth/ring_down.hpp"

namespace carillon::cli {

namespace {

SceneEffect read(core::ConfigNode&, const Scene&) {
  SceneEffect effect;
  effect.asked_by = "every material has damping";
  effect.start = [](const std::filesystem::path&) {
    EffectParts parts;
    parts.body = [](RingingBody& body) {
      body.decay_rates = synth::decay_rates(*body.modes, damping_of(*body.materials));
    };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect damping_effect = {
    .name = "damping", .description = "Rayleigh damping of every mode", .read = read};

}  // namespace carillon::cli
