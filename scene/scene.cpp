#include "scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene/detail/given_strikes.hpp"
#include "scene/strikes.hpp"

namespace carillon::scene {

using core::at_key;
using core::ConfigNode;
using core::Dimension;
using core::path_beside;
using core::Range;

namespace {

AudioConfig read_audio(ConfigNode node) {
  AudioConfig audio;
  audio.sample_rate = node.quantity("sample_rate", Dimension::frequency, 44100);
  if (!(audio.sample_rate >= 1000 && audio.sample_rate <= 384000)) {
    node.fail("sample_rate", "must lie between 1 kHz and 384 kHz");
  }
  audio.seconds = node.quantity("seconds", Dimension::time, 1);
  if (!(audio.seconds > 0 && audio.seconds <= 600)) {
    node.fail("seconds", "must be above 0 and at most 600 s");
  }
  if (audio.samples() == 0) node.fail("seconds", "is less than one sample");
  audio.dtype = node.choice("dtype", {"float32", "int16"}, "float32") == "int16"
                    ? core::SampleFormat::int16
                    : core::SampleFormat::float32;
  audio.gain = node.positive("gain", Dimension::none, 1);
  return audio;
}

Repeats read_repeats(ConfigNode& node) {
  const auto counts = [&](const char* key) {
    constexpr double maximum = 100;
    const Range range = node.range(key, Dimension::none, Range{0, 0});
    if (!(range.low >= 0 && range.high <= maximum && range.low == std::floor(range.low) &&
          range.high == std::floor(range.high))) {
      node.fail(key, fmt::format("must be whole numbers from 0 to {}", maximum));
    }
    return range;
  };
  Repeats repeats{counts("earlier"), counts("later"), {}};
  if (!repeats.any()) {
    if (node.has("interval")) {
      node.fail("interval", "there is one strike in a clip", "give `earlier` or `later`, too");
    }
    return repeats;
  }
  constexpr double longest = 10;
  repeats.interval = node.range("interval", Dimension::time, Range{0.1, 0.5});
  if (!(repeats.interval.low > 0 && repeats.interval.high <= longest)) {
    node.fail("interval", fmt::format("must lie above 0 and at most {} s", longest));
  }
  return repeats;
}

StrikeConfig read_strikes(ConfigNode node, const std::string& file_name) {
  StrikeConfig strikes;
  strikes.repeats = read_repeats(node);
  if (node.has("csv")) {
    strikes.csv = path_beside(file_name, node.text("csv"));
    at_key(node, "csv", [&] { strikes.given = read_given_strikes(strikes.csv); });
    return strikes;
  }
  strikes.per_object = static_cast<int>(node.integer("per_object", 1, 1000000, 8));
  strikes.impulse = node.range("impulse", Dimension::impulse, Range{0.005, 0.05});
  strikes.contact_time = node.range("contact_time", Dimension::time, Range{1e-4, 5e-4});
  if (!(strikes.impulse.low > 0)) node.fail("impulse", "must be positive");
  if (!(strikes.contact_time.low > 0)) node.fail("contact_time", "must be positive");
  strikes.spread = node.quantity("spread", Dimension::angle, 0);
  if (!(strikes.spread >= 0 && strikes.spread < std::numbers::pi / 2)) {
    node.fail("spread", "must be at least 0 and below 90 deg");
  }
  return strikes;
}

/// What says how objects are struck has no meaning where they move.
void refuse_strikes(const ConfigNode& root) {
  for (const char* key : {"strikes", "striker"}) {
    if (!root.has(key)) continue;
    root.fail(key, "goes with objects that are struck, not with `motion`",
              "strikes follow from the motion; remove one of the two");
  }
}

/// What `effects: {name: ...}` and the scene's needs come to.
EffectDecision decide(const Effect& effect, SceneEffect in_scene, ConfigNode& switches,
                      bool with_files) {
  EffectDecision decision{&effect, false, "", std::move(in_scene)};
  const std::string wish = effect_switch(switches, effect.name);
  const std::string place = wish == "auto" ? ""
                                           : fmt::format("effects.{}: {} ({})", effect.name, wish,
                                                         switches.where(effect.name));
  const bool can_run = decision.in_scene.reason_off.empty();
  if (wish == "off") {
    decision.reason = place;
  } else if (!can_run) {
    if (wish == "on") {
      switches.fail(effect.name, fmt::format("cannot be on: {}", decision.in_scene.reason_off),
                    "give it what it needs, or write auto");
    }
    decision.reason = decision.in_scene.reason_off;
  } else {
    decision.enabled = true;
    if (with_files && decision.in_scene.check) decision.in_scene.check();
    decision.reason = wish == "on" ? place : decision.in_scene.asked_by;
  }
  return decision;
}

}  // namespace

std::string effect_switch(ConfigNode& switches, const std::string& name) {
  const std::string word = switches.choice(name, {"auto", "on", "off", "true", "false"}, "auto");
  // What programs that write YAML 1.1 make of on and off.
  return word == "true" ? "on" : word == "false" ? "off" : word;
}

std::size_t AudioConfig::samples() const {
  return static_cast<std::size_t>(std::llround(seconds * sample_rate));
}

std::size_t Scene::rows() const {
  return runs("radiation") ? listeners.size() : 1;
}

bool Scene::runs(std::string_view effect) const {
  return std::any_of(effects.begin(), effects.end(), [&](const EffectDecision& decision) {
    return decision.enabled && effect == decision.effect->name;
  });
}

std::string Scene::unheard() const {
  if (listeners.empty()) return "no listener is placed";
  return runs("radiation") ? "" : "radiation is off: the dry signal is no pressure";
}

std::size_t Scene::rendered_samples() const {
  return audio.samples() + samples_before(strikes.repeats, audio.sample_rate);
}

std::size_t Scene::strikes_per_object() const {
  return strikes.given.empty() ? static_cast<std::size_t>(strikes.per_object)
                               : strikes.given.size();
}

namespace {

/// Of one sound, with its fraction of what is done once for its object.
double effect_seconds(const Scene& scene, const SceneEffect& effect, int modes) {
  double seconds = effect.seconds_per_sound * static_cast<double>(scene.rows());
  if (effect.seconds_by_modes) seconds += effect.seconds_by_modes(modes);
  return seconds + effect.seconds_per_object / static_cast<double>(scene.strikes_per_object());
}

}  // namespace

double Scene::seconds_per_shape() const {
  double seconds = 0;
  for (const EffectDecision& decision : effects) {
    if (decision.enabled) seconds += decision.in_scene.seconds_per_shape;
  }
  return seconds;
}

double Scene::seconds_per_sound(int modes) const {
  // Ring-down kernel, one core of a 2.3 GHz Xeon (docs/sound/speed.md).
  constexpr double seconds_per_mode_sample = 4e-10;
  const double count = static_cast<double>(rows());
  double seconds =
      seconds_per_mode_sample * modes * static_cast<double>(rendered_samples()) * count;
  for (const EffectDecision& decision : effects) {
    if (decision.enabled) seconds += effect_seconds(*this, decision.in_scene, modes);
  }
  return seconds;
}

Scene read_scene(ConfigNode& root, const std::string& file_name, std::span<const Effect> registry,
                 const SceneSurroundings& around) {
  Scene scene;
  scene.file_name = file_name;
  scene.materials = around.materials;
  scene.materials_place = around.materials_place;
  scene.parts = around.parts;
  scene.variants = around.variants;
  scene.audio = read_audio(root.child("audio"));
  const bool moves = root.has("motion");
  if (moves) {
    refuse_strikes(root);
  } else {
    scene.strikes = read_strikes(root.child("strikes"), file_name);
  }
  for (ConfigNode& node : root.children("listeners")) {
    const std::vector<double> p = node.quantities("position", Dimension::length, 3);
    scene.listeners.push_back({{p[0], p[1], p[2]}});
  }
  ConfigNode switches = root.child("effects");
  for (const Effect& effect : registry) {
    SceneEffect in_scene = effect.read(root, scene);
    const std::string_view stage = effect.stage;
    if (moves && (stage == "strike" || stage == "rings")) {
      in_scene.reason_off =
          fmt::format("strikes follow from the motion: ({})", root.where("motion"));
    }
    scene.effects.push_back(decide(effect, std::move(in_scene), switches, around.with_files));
  }
  return scene;
}

nlohmann::json to_json(const PlannedEffect& effect) {
  return {{"name", effect.name},
          {"enabled", effect.enabled},
          {"reason", effect.reason},
          {"seconds_per_sound", effect.seconds_per_sound},
          {"seconds_per_shape", effect.seconds_per_shape}};
}

std::vector<PlannedEffect> plan_effects(const Scene& scene, int modes) {
  std::vector<PlannedEffect> list;
  for (const EffectDecision& decision : scene.effects) {
    PlannedEffect planned{std::string(decision.effect->name), decision.enabled, decision.reason};
    if (decision.enabled) {
      planned.seconds_per_sound = effect_seconds(scene, decision.in_scene, modes);
      planned.seconds_per_shape = decision.in_scene.seconds_per_shape;
    }
    list.push_back(std::move(planned));
  }
  return list;
}

}  // namespace carillon::scene
