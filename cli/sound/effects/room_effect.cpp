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
  } else if (room.order == 0) {
    effect.reason_off = "order 0: no image sources are asked for";
  }
  effect.seconds_per_sound = kSecondsPerSample * static_cast<double>(scene.audio.samples());
  // Images take less time than reading them from a file: nothing is cached beyond the chain.
  effect.start = [room](const std::filesystem::path&) {
    auto spectra = std::make_shared<RoomSpectra>(&synth::RoomResponse::images, "");
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
        spectra->convolver().add(
            std::span<const float>(sound.direct).subspan(r * row.size(), row.size()),
            spectra->of(options).spectrum, row);
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
