#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/audio.hpp"
#include "core/config.hpp"
#include "scene/effect.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::scene {

/// One strike that was given rather than drawn, in the object's coordinates at size 1.
struct GivenStrike {
  std::string shape;  ///< shape id; "" or "*": every shape
  Vec3 position;
  std::optional<Vec3> direction;
  double impulse;       ///< [N s]
  double contact_time;  ///< [s]
};

/// Further strikes in a sample's clip, each as the first.
struct Repeats {
  core::Range earlier;   ///< before the clip begins, whose tails it has; whole numbers
  core::Range later;     ///< in the clip; likewise
  core::Range interval;  ///< from each to the next [s], drawn uniformly in the logarithm

  bool any() const { return earlier.high > 0 || later.high > 0; }
  /// Of what sounds before the clip begins [s].
  double lead() const { return earlier.high * interval.high; }
};

struct StrikeConfig {
  int per_object = 8;        ///< strikes of each shape, the same points for all its variants
  core::Range impulse;       ///< [N s], drawn uniformly in the logarithm
  core::Range contact_time;  ///< [s], likewise
  double spread = 0;         ///< [rad] largest angle between force and inward normal
  Repeats repeats;
  std::vector<GivenStrike> given;  ///< from a CSV file; then nothing is drawn
  std::string csv;                 ///< path of that file; "" for none
};

struct AudioConfig {
  double sample_rate = 44100;  ///< [Hz]
  double seconds = 1;
  core::SampleFormat dtype = core::SampleFormat::float32;
  double gain = 1;  ///< full scale per m/s (dry) or per Pa (listeners); recorded, never adapted
  std::size_t samples() const;
};

/// What is struck how, where it is heard, and what happens to the sound on its way.
struct Scene {
  std::string file_name;  ///< of the configuration: paths in it are meant from where it lies
  AudioConfig audio;
  StrikeConfig strikes;
  std::vector<synth::material::Material>
      materials;                ///< every one that an object is made of; may be empty
  std::string materials_place;  ///< as SceneSurroundings::materials_place
  std::size_t parts = 1;        ///< as Sound::parts
  std::size_t variants = 1;     ///< materials and sizes that a shape is struck in, at the most
  std::vector<synth::modal::Listener> listeners;  ///< from the centre of the object's box
  std::vector<EffectDecision> effects;            ///< every effect there is, on or off, in order

  /// Samples of a row that effects work on: the clip, and before it the tails of earlier strikes.
  std::size_t rendered_samples() const;
  /// Of a sound: one per listener, or one of the dry signal.
  std::size_t rows() const;
  bool runs(std::string_view effect) const;
  /// Why nothing hears pressure in air: no listener, or radiation is off; "" where something does.
  /// For effects after radiation.
  std::string unheard() const;
  /// Of each object: drawn, or given ones.
  std::size_t strikes_per_object() const;
  /// Estimated seconds of one sound: modes ringing, the effects that are on, and the sound's share
  /// of what they do once for its object.
  double seconds_per_sound(int modes) const;
  /// Estimated seconds of what effects do once for a shape, beside its sounds.
  double seconds_per_shape() const;
};

/// What a scene needs to know of the rest of a configuration.
struct SceneSurroundings {
  std::vector<synth::material::Material> materials =
      {};                            ///< of all objects, where that is known already
  std::string materials_place = {};  ///< what names them, "materials: (kitchen.yaml:6)"; may be ""
  std::size_t parts = 1;             ///< as Sound::parts
  std::size_t variants = 1;          ///< as Scene::variants
  bool with_files = true;  ///< faults of large files that effects read are looked for, too
};

/// Reads `audio`, `strikes`, `listeners`, `effects` and the keys of every effect.
/// @param registry   the effects that there are
/// @param around     what stands elsewhere in the configuration
/// @throws ConfigError
Scene read_scene(core::ConfigNode& root, const std::string& file_name,
                 std::span<const Effect> registry = effects(),
                 const SceneSurroundings& around = {});

/// The word for an effect under `effects:`, `auto`, `on` or `off`; `true` and `false` are on and
/// off.
/// @throws ConfigError  another word
std::string effect_switch(core::ConfigNode& switches, const std::string& name);

/// An effect as a scene decides it, and what it should cost.
struct PlannedEffect {
  std::string name{};
  bool enabled = false;
  std::string reason{};
  double seconds_per_sound = 0, seconds_per_shape = 0;  ///< estimated; 0 where it is off
};
/// `name, enabled, reason, seconds_per_sound, seconds_per_shape`
nlohmann::json to_json(const PlannedEffect& effect);

/// Every effect there is, in order.
/// @param modes  of an object, where the cost depends on them
std::vector<PlannedEffect> plan_effects(const Scene& scene, int modes = 60);

}  // namespace carillon::scene
