#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/columns.hpp"
#include "core/config.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/radiation/equivalent_sources.hpp"

namespace carillon::scene {

struct Scene;
struct SupportsConfig;

/// An object that is about to ring: at its size and of its materials, its own damping known.
struct RingingObject {
  std::string id;     ///< shape/material/size
  std::string shape;  ///< the same in all of its materials and sizes
  const solvers::modes::Modes* modes =
      nullptr;  ///< at the object's size, as what holds it leaves them
  std::shared_ptr<const solvers::modes::Modes> held = {};  ///< keeps them where springs hold it
  const std::vector<synth::material::Material>* materials =
      nullptr;                                    ///< one per region of the modes
  std::vector<double> decay_rates;                ///< d of each mode [1/s]
  Vec3 centre = Vec3::Zero();                     ///< of its bounding box [m]
  bool moves = false;                             ///< in a scene that does
  const SupportsConfig* held_by = nullptr;        ///< in such a scene, what holds it; null: nothing
  std::vector<synth::modal::Listener> listeners;  ///< in the object's coordinates; may be empty
  /// Pressure at the listeners per modal motion; without rows the dry signal is heard. Made once
  /// for an object, as it does not depend on the strike.
  synth::modal::Readout pressure;
  /// Its radiation, for objects that move; null without equivalent sources.
  std::shared_ptr<const synth::radiation::SourceField> field;
};

/// One sound on its way through the effects: each takes what is there and adds its part.
struct Sound {
  const RingingObject* object = nullptr;
  std::uint64_t seed = 0;  ///< of the data set; random streams are keyed by (seed, id, purpose)
  std::uint64_t id = 0;    ///< of the sample
  std::size_t part = 0;    ///< of `parts` whose rooms and noises have nothing in common
  std::size_t parts = 1;   ///< (training, validation and test of either split)
  synth::modal::Strike strike;        ///< without a force over time until an effect gives it one
  double contact_time = 0;            ///< drawn or given [s]
  synth::modal::RingDown rings;       ///< what is about to ring; effects of modes change it
  std::size_t before = 0;             ///< samples that are rendered before the clip begins
  std::vector<double> strikes = {0};  ///< times of the strike, which may be repeated [s], from
                                      ///< where rendering begins
  std::vector<float> audio;           ///< rows (listeners, or one) x samples
  std::vector<float> direct;  ///< audio before a room's early reflections, with what air has
                              ///< taken from it; empty without them
  std::size_t rows = 1;
  double sample_rate = 44100;
  std::size_t modes = 0;                ///< that sound
  std::size_t modes_above_nyquist = 0;  ///< left out, as they would oscillate at or above it
  core::Columns* record =
      nullptr;  ///< what was drawn and found, so that the sample can be made again

  std::span<float> row(std::size_t r) {
    const std::size_t count = audio.size() / rows;
    return std::span(audio).subspan(r * count, count);
  }
};

/// The working parts of an effect in one chain: what it does to objects and to sounds, and when. An
/// empty function does nothing and is not called. Parts share state of their own (an FFT's plan,
/// room responses) and belong to one thread.
struct EffectParts {
  std::function<void(RingingObject&)> object;  ///< once per object
  std::function<void(Sound&)> strike;          ///< the strike is drawn, nothing rings yet
  std::function<void(Sound&)> rings;           ///< modes, their damping and gains are known
  std::function<void(Sound&)> audio;           ///< samples are there, in m/s or Pa
  std::function<void(Sound&)> full_scale;      ///< gain is applied: 1 is full scale
};

/// An effect as one scene has it.
struct SceneEffect {
  /// What in the configuration calls for it, with its place: "room: (kitchen.yaml:12)".
  std::string asked_by;
  /// Why it does not run: nothing asks for it ("no room:"), or it was asked for and cannot be or
  /// need not be ("no listener is placed"). Empty: it can run, and with `auto` it does.
  std::string reason_off;
  double seconds_per_sound = 0;  ///< estimated cost of one sound, one row
  double seconds_per_object =
      0;  ///< once for a shape in a material and size, whatever its listeners
  double seconds_per_shape = 0;  ///< once for a shape
  double memory = 0;             ///< estimated, of its working parts [byte]
  /// Further cost of one sound of an object of so many modes, whatever its rows; empty: none.
  std::function<double(int modes)> seconds_by_modes;
  /// Faults of the files it reads, or of this program, that can be found cheaply; called when the
  /// configuration is read, once it is known to be on. Empty: nothing to check.
  /// @throws ConfigError
  std::function<void()> check;
  /// Hash of the files it reads beside the configuration; asked for only while it is on. Empty:
  /// none.
  std::function<std::string()> content;
  /// Makes the working parts; never called while it is off. Empty for effects outside the chain.
  /// @param cache  folder that outlives the run, for what is dear to compute; empty: none
  std::function<EffectParts(const std::filesystem::path& cache)> start;
};

/// A part of the physics or of the output that only runs when a scene calls for it. One file, one
/// line in the list of effects.cpp.
struct Effect {
  const char* name;  ///< key under `effects:` and in plan and trace
  const char* description;
  const char* key;  ///< of the configuration, whose values say how it acts
  /// Where it does its part: `object`, `strike`, `rings`, `audio` or `full scale` (as in
  /// EffectParts), `motion` for what scenes that move are made of, or `view` for what is made
  /// beside the chain.
  const char* stage;
  /// Reads the effect's keys of a configuration and says whether the scene calls for it. `scene`
  /// holds audio, strikes and listeners, and of the effects what was decided of earlier ones.
  /// @throws ConfigError
  SceneEffect (*read)(core::ConfigNode& root, const Scene& scene);
};

/// Whether an effect runs in a scene, and why.
struct EffectDecision {
  const Effect* effect = nullptr;
  bool enabled = false;
  std::string reason;
  SceneEffect in_scene;
};

/// All effects in the order they act.
std::span<const Effect> effects();

}  // namespace carillon::scene
