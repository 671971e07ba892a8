#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/trace.hpp"
#include "scene/scene.hpp"

namespace carillon::scene {

/// A sound as it lies in a file: one channel per row.
core::AudioClip clip_of(const Sound& sound);

/// The effects of a scene at work, one after the other. Those that are off are not started: they
/// have no state, take no memory and cannot be called. Belongs to one thread.
class SoundChain {
 public:
  /// @param cache  folder for what effects find dear to compute; empty: none
  /// @param trace  calls and seconds of every effect are added to it
  SoundChain(const Scene& scene, const std::filesystem::path& cache, core::Trace& trace);

  /// An object as the effects of objects leave it: its decay rates, and the pressure at listeners.
  /// The modes and materials must outlive it.
  /// @param shape  what the object is in a material and a size
  RingingObject prepare(const std::string& shape, const std::string& id,
                        const solvers::modes::Modes& modes,
                        const std::vector<synth::material::Material>& materials);

  /// The same of an object in a scene that moves, whose pressure follows from its `field` at each
  /// of its poses.
  /// @param held_by  what fixes it; null: it is free. Must outlive the object
  RingingObject prepare_moving(const std::string& shape, const std::string& id,
                               const solvers::modes::Modes& modes,
                               const std::vector<synth::material::Material>& materials,
                               const SupportsConfig* held_by);

  /// Makes the audio of a sound whose object, strike and keys are set: rows x samples at full
  /// scale.
  void make(Sound& sound);
  /// The first half of it: what rings, as the effects of strikes and modes leave it.
  void ring(Sound& sound);
  /// The last part of it, for audio that is there in m/s or Pa: its way to full scale.
  void finish(Sound& sound);

 private:
  template <class Subject>
  void run(std::function<void(Subject&)> EffectParts::*stage, Subject& subject);

  struct Running {
    const char* name;
    EffectParts parts;
  };
  const Scene& scene_;
  core::Trace& trace_;
  std::vector<Running> running_;
};

}  // namespace carillon::scene
