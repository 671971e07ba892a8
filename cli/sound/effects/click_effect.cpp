#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>

#include "cli/sound/effects/list.hpp"
#include "cli/sound/effects/radiation_model.hpp"
#include "cli/sound/scene.hpp"
#include "synth/acceleration_click.hpp"

namespace carillon::cli {

namespace {

/// Sources of the bodies seen so far.
using Sources = std::map<std::string, synth::RigidSource>;

void add_click(Sound& sound, const Sources& sources) {
  const RingingBody& body = *sound.body;
  const synth::RigidSource& source = sources.at(body.id);
  double peak = 0;
  for (std::size_t r = 0; r < sound.rows; ++r) {
    const auto row = sound.row(r);
    for (const double blow : sound.blows) {
      const std::vector<float> click = synth::acceleration_click(
          source, sound.strike.impulse * sound.strike.direction, sound.strike.force,
          body.listeners[r].position, sound.sample_rate, row.size(), blow);
      for (std::size_t n = 0; n < row.size(); ++n) {
        row[n] += click[n];
        peak = std::max(peak, std::abs(static_cast<double>(click[n])));
      }
    }
  }
  if (sound.record != nullptr) sound.record->add("click_peak", peak, "Pa");
}

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  core::ConfigNode node = root.child("click");
  const bool held = node.flag("held", false);
  core::ConfigNode radiation = root.child("radiation");
  const bool baffled = read_radiation_model(radiation) == "rayleigh_integral";
  core::ConfigNode switches = root.child("effects");
  const bool wanted = effect_switch(switches, "click") == "on";
  if (const std::string why = scene.unheard(); !why.empty()) {
    effect.reason_off = why;
  } else if (held) {
    effect.reason_off = fmt::format("the body is held ({})", node.where("held"));
  } else if (baffled && !wanted) {
    effect.reason_off =
        fmt::format("the sheet sits in a baffle: radiation.model ({})", radiation.where("model"));
  } else {
    effect.asked_by = fmt::format("listeners: ({})", root.where("listeners"));
  }
  effect.seconds_per_sound = 6e-5;
  effect.start = [](const std::filesystem::path&) {
    const auto sources = std::make_shared<Sources>();
    EffectParts parts;
    parts.body = [sources](RingingBody& body) {
      (*sources)[body.id] = synth::rigid_source(body.modes->surface, body.modes->mass);
    };
    parts.audio = [sources](Sound& sound) { add_click(sound, *sources); };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect click_effect = {
    .name = "click",
    .description = "sound of the struck body's jump as a rigid whole (acceleration noise)",
    .key = "click",
    .stage = "audio",
    .read = read};

}  // namespace carillon::cli
