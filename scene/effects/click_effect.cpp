#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/numbers.hpp"
#include "scene/effects/detail/list.hpp"
#include "scene/effects/detail/radiation_model.hpp"
#include "scene/scene.hpp"
#include "synth/contact/acceleration_click.hpp"

namespace carillon::scene {

namespace {

/// An object that jumps, and which of its listeners hear that.
struct Jumping {
  synth::contact::RigidSource source;
  std::vector<bool> heard;
  std::int64_t left_out = 0;  ///< listeners too near for what a sphere says of a click
};
/// Of the objects seen so far.
using Objects = std::map<std::string, Jumping>;

/// @param wanted  the click was asked for by hand: where it cannot be is an error, later on
Jumping look_at(const RingingObject& object, bool wanted) {
  Jumping jumping;
  jumping.source = synth::contact::rigid_source(object.modes->surface, object.modes->mass);
  for (const synth::modal::Listener& listener : object.listeners) {
    const bool heard = wanted || synth::contact::hears_click(jumping.source, listener.position);
    jumping.heard.push_back(heard);
    if (!heard) ++jumping.left_out;
  }
  if (jumping.left_out > 0) {
    spdlog::warn(
        "{}: no click at {} of {} listeners, less than {:.3g} m from the object's centre (inside "
        "the "
        "sphere that stands for it)",
        object.id, jumping.left_out, object.listeners.size(), jumping.source.radii.maxCoeff());
  }
  return jumping;
}

void add_click(Sound& sound, const Objects& objects) {
  const RingingObject& object = *sound.object;
  const Jumping& jumping = objects.at(object.id);
  double peak = 0;
  for (std::size_t r = 0; r < sound.rows; ++r) {
    if (!jumping.heard[r]) continue;
    const auto row = sound.row(r);
    for (const double strike : sound.strikes) {
      const std::vector<float> click = synth::contact::acceleration_click(
          jumping.source, sound.strike.impulse * sound.strike.direction, sound.strike.force,
          object.listeners[r].position, sound.sample_rate, row.size(), strike);
      for (std::size_t n = 0; n < row.size(); ++n) row[n] += click[n];
      peak = std::max(peak, core::peak(std::span(click).first(row.size())));
    }
  }
  if (sound.record == nullptr) return;
  sound.record->add("click_peak", peak);
  sound.record->add("click_left_out", jumping.left_out);
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
    effect.reason_off = fmt::format("the object is held ({})", node.where("held"));
  } else if (baffled && !wanted) {
    effect.reason_off =
        fmt::format("the sheet sits in a baffle: radiation.model ({})", radiation.where("model"));
  } else {
    effect.asked_by = fmt::format("listeners: ({})", root.where("listeners"));
  }
  effect.seconds_per_sound = 6e-5;
  if (root.has("motion")) return effect;  // the motion's sound has the clicks of its strikes
  effect.start = [wanted](const std::filesystem::path&) {
    const auto objects = std::make_shared<Objects>();
    EffectParts parts;
    parts.object = [wanted, objects](RingingObject& object) {
      (*objects)[object.id] = look_at(object, wanted);
    };
    parts.audio = [objects](Sound& sound) { add_click(sound, *objects); };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect click_effect = {
    .name = "click",
    .description = "sound of the struck object's jump as a rigid whole (acceleration noise)",
    .key = "click",
    .stage = "audio",
    .read = read};

}  // namespace carillon::scene
