#include <algorithm>
#include <memory>

#include "scene/effects/detail/list.hpp"
#include "scene/room_scene.hpp"

namespace carillon::scene {

namespace {

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  const std::optional<RoomScene> asked = ask_for_room(root, scene, effect);
  if (!asked) return effect;
  const RoomScene& room = *asked;
  if (effect.reason_off.empty()) {
    // Where nothing is reflected air may still be heard: it dulls what comes from afar.
    if (!air_is_heard(room, scene)) effect.reason_off = why_no_reflection(room, scene);
    effect.seconds_per_sound = seconds_per_sound(room, scene, true);
  }
  effect.start = [room = *asked](const std::filesystem::path& cache) {
    auto spectra = std::make_shared<RoomSpectra>(&synth::room::RoomResponse::images,
                                                 cache.empty() ? cache : cache / "rooms");
    EffectParts parts;
    parts.audio = [room, spectra](Sound& sound) {
      const Room place = room_of(room, sound, relative_listeners(*sound.object));
      const std::vector<Vec3>& listeners = place.listeners;
      if (sound.record != nullptr) record_room(*sound.record, room, place);
      sound.direct = sound.audio;
      for (std::size_t r = 0; r < sound.rows && r < listeners.size(); ++r) {
        const std::span<float> row = sound.row(r);
        synth::room::RoomOptions options =
            room_options(room, place, listeners[r], sound.sample_rate, row.size(), sound.seed);
        options.with_tail = false;
        const RoomSpectra::Entry& entry = spectra->of(options);
        spectra->take_air(entry, row);
        const auto direct = std::span(sound.direct).subspan(r * row.size(), row.size());
        std::copy(row.begin(), row.end(), direct.begin());
        spectra->convolver().add(direct, entry.spectrum, row);
      }
    };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect room_effect = {.name = "room",
                            .description = "early reflections of a shoebox room (image sources)",
                            .key = "room",
                            .stage = "audio",
                            .read = read};

}  // namespace carillon::scene
