#include "scene/chain.hpp"

#include <cmath>
#include "synth/modal/streaming_renderer.hpp"

namespace carillon::scene {

core::AudioClip clip_of(const Sound& sound) {
  core::AudioClip clip;
  clip.sample_rate = static_cast<int>(std::lround(sound.sample_rate));
  clip.channels = static_cast<int>(sound.rows);
  clip.samples.resize(sound.audio.size());
  const std::size_t count = sound.audio.size() / sound.rows;
  for (std::size_t i = 0; i < sound.audio.size(); ++i) {
    clip.samples[i % count * sound.rows + i / count] = sound.audio[i];
  }
  return clip;
}

namespace {

/// Drops what was rendered before the clip begins.
void begin_clip(Sound& sound) {
  if (sound.before == 0) return;
  std::vector<float> clip;
  for (std::size_t r = 0; r < sound.rows; ++r) {
    const std::span<float> row = sound.row(r).subspan(sound.before);
    clip.insert(clip.end(), row.begin(), row.end());
  }
  sound.audio = std::move(clip);
  sound.direct.clear();
  sound.before = 0;
}

}  // namespace

SoundChain::SoundChain(const Scene& scene, const std::filesystem::path& cache, core::Trace& trace)
    : scene_(scene), trace_(trace) {
  for (const EffectDecision& decision : scene.effects) {
    if (!decision.enabled || !decision.in_scene.start) continue;
    running_.push_back({decision.effect->name, decision.in_scene.start(cache)});
  }
}

template <class Subject>
void SoundChain::run(std::function<void(Subject&)> EffectParts::*stage, Subject& subject) {
  for (const Running& effect : running_) {
    const auto& part = effect.parts.*stage;
    if (!part) continue;
    const core::ScopedTimer timer(trace_.effects[effect.name]);
    part(subject);
  }
}

namespace {

RingingObject object_of(const std::string& shape, const std::string& id,
                        const solvers::modes::Modes& modes,
                        const std::vector<synth::material::Material>& materials) {
  RingingObject object;
  object.id = id;
  object.shape = shape;
  object.modes = &modes;
  object.materials = &materials;
  object.decay_rates.assign(modes.size(), 0.0);
  const solvers::mesh::Box box = solvers::mesh::bounding_box(modes.surface.nodes);
  object.centre = 0.5 * (box.low + box.high);
  return object;
}

}  // namespace

RingingObject SoundChain::prepare(const std::string& shape, const std::string& id,
                                  const solvers::modes::Modes& modes,
                                  const std::vector<synth::material::Material>& materials) {
  RingingObject object = object_of(shape, id, modes, materials);
  for (const synth::modal::Listener& listener : scene_.listeners) {
    object.listeners.push_back({object.centre + listener.position});
  }
  run(&EffectParts::object, object);
  return object;
}

RingingObject SoundChain::prepare_moving(const std::string& shape, const std::string& id,
                                         const solvers::modes::Modes& modes,
                                         const std::vector<synth::material::Material>& materials,
                                         const SupportsConfig* held_by) {
  RingingObject object = object_of(shape, id, modes, materials);
  object.moves = true;
  object.held_by = held_by;
  run(&EffectParts::object, object);
  return object;
}

void SoundChain::ring(Sound& sound) {
  const RingingObject& object = *sound.object;
  sound.sample_rate = scene_.audio.sample_rate;
  run(&EffectParts::strike, sound);
  const bool heard = !object.pressure.delays.empty();
  sound.rings = synth::modal::ring_down(
      *object.modes, object.decay_rates, sound.strike,
      heard ? object.pressure : synth::modal::point_velocity(*object.modes, sound.strike.point));
  run(&EffectParts::rings, sound);
}

void SoundChain::make(Sound& sound) {
  ring(sound);
  sound.rows = sound.rings.readout.delays.size();
  {
    const core::ScopedTimer timer(trace_.stages["ring"]);
    sound.modes = synth::modal::sounding_modes(sound.rings, sound.sample_rate);
    sound.modes_above_nyquist = synth::modal::modes_above_nyquist(sound.rings, sound.sample_rate);
    const std::size_t count = sound.before + scene_.audio.samples();
    sound.audio =
        sound.strikes == std::vector<double>{0}
            ? synth::modal::synthesize(sound.rings, sound.strike.force, sound.sample_rate, count)
            : synth::modal::synthesize_strikes(sound.rings, sound.strike.force, sound.strikes,
                                               sound.sample_rate, count);
  }
  finish(sound);
}

void SoundChain::finish(Sound& sound) {
  run(&EffectParts::audio, sound);
  begin_clip(sound);
  for (float& value : sound.audio) value = static_cast<float>(value * scene_.audio.gain);
  run(&EffectParts::full_scale, sound);
}

}  // namespace carillon::scene
