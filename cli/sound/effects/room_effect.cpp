#include <algorithm>
#include <memory>

#include "cli/sound/effects/list.hpp"
#include "cli/sound/room_scene.hpp"

namespace carillon::cli {

namespace {

/// Of a convolution, per sample and row; docs/sound/room.md.
constexpr double kSecondsPerSample = 1.3e-8;

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  if (!root.has("room")) {
    effect.reason_off = "no room:";
    return effect;
  }
  const RoomScene room = read_room(root, scene);
  effect.asked_by = "room: (" + root.where("room") + ")";
  if (const std::string why = scene.unheard(); !why.empty()) {
    effect.reason_off = why;
  } else {
    // Where nothing is reflected air may still be heard: it dulls what comes from afar.
    const bool air = air_is_heard(room, scene);
    if (!air) effect.reason_off = why_no_reflection(room, scene);
    effect.seconds_per_sound = 2 * kSecondsPerSample * static_cast<double>(scene.audio.samples()) +
                               seconds_of_response(room, scene, true);
  }
  effect.memory = memory_of_spectra(room, scene);
  effect.start = [room](const std::filesystem::path& cache) {
    // A few images take less time than reading them from a file.
    const bool kept = room.order > kOrderOfCache && !cache.empty();
    auto spectra = std::make_shared<RoomSpectra>(&synth::RoomResponse::images,
                                                 kept ? cache / "rooms" : std::filesystem::path());
    EffectParts parts;
    parts.audio = [room, spectra](Sound& sound) {
      const auto listeners = relative_listeners(*sound.body);
      const Room place = room_of(room, sound, listeners);
      if (sound.record != nullptr) record_room(*sound.record, room, place);
      sound.direct = sound.audio;
      for (std::size_t r = 0; r < sound.rows && r < listeners.size(); ++r) {
        const std::span<float> row = sound.row(r);
        synth::RoomOptions options =
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

}  // namespace carillon::cli
