#include <algorithm>

#include "scene/effects/detail/list.hpp"
#include "scene/scene.hpp"

namespace carillon::scene {

namespace {

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  const auto& given = scene.strikes.given;
  const bool finite = given.empty() || std::any_of(given.begin(), given.end(), [](const auto& s) {
                        return s.contact_time > 0;
                      });
  if (scene.runs("striker")) {
    effect.reason_off = "striker: (" + root.where("striker") + ") gives the force";
  } else if (finite) {
    effect.asked_by = root.has("strikes") ? "strikes: (" + root.where("strikes") + ")"
                                          : "strikes.contact_time is not zero";
  } else {
    effect.reason_off = "every given strike is an ideal impulse";
  }
  effect.start = [](const std::filesystem::path&) {
    EffectParts parts;
    parts.strike = [](Sound& sound) { sound.strike.force.duration = sound.contact_time; };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect contact_effect = {.name = "contact",
                               .description = "finite contact pulse of the striker",
                               .key = "strikes",
                               .stage = "strike",
                               .read = read};

}  // namespace carillon::scene
