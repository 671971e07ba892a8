#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "scene/effects/detail/list.hpp"
#include "scene/room_scene.hpp"

namespace carillon::scene {

namespace {

/// Why no tail of the scene's rooms is heard; empty when one may be. Judged by the smallest and the
/// largest room, with the object in the middle and at the edges of its places.
std::string why_silent(const RoomScene& room, const Scene& scene) {
  std::vector<Vec3> listeners;
  for (const synth::modal::Listener& listener : scene.listeners)
    listeners.push_back(listener.position);
  double loudest = -1e300;
  double first = 1e300;
  for (const bool largest : {false, true}) {
    std::vector<Room> rooms = {typical_room(room, scene, largest, listeners)};
    for (Room& edge : rooms_at_the_edges(room, scene, largest, listeners)) {
      rooms.push_back(std::move(edge));
    }
    for (const Room& place : rooms) {
      for (const Vec3& listener : place.listeners) {
        const synth::room::TailPlan plan = synth::room::room_tail_plan(room_options(
            room, place, listener, scene.audio.sample_rate, scene.rendered_samples(), 0));
        loudest = std::max(loudest, plan.energy_db());
        first = std::min(first, plan.start);
        if (loudest >= synth::room::inaudible_tail && first < scene.audio.seconds) return "";
      }
    }
  }
  if (loudest < synth::room::inaudible_tail) {
    return fmt::format("absorption so high that the tail is inaudible (energy {:.0f} dB)",
                       std::max(loudest, -999.0));
  }
  if (first >= scene.audio.seconds) {
    return fmt::format(
        "the tail begins {:.2g} s after the direct sound at the earliest, beyond the clip's {:.2g} "
        "s",
        first, scene.audio.seconds);
  }
  return "";
}

SceneEffect read(core::ConfigNode& root, const Scene& scene) {
  SceneEffect effect;
  const std::optional<RoomScene> asked = ask_for_room(root, scene, effect);
  if (!asked) return effect;
  const RoomScene& room = *asked;
  if (effect.reason_off.empty()) {
    effect.reason_off = why_silent(room, scene);
    effect.seconds_per_sound = seconds_per_sound(room, scene, false);
  }
  effect.start = [room = *asked](const std::filesystem::path& cache) {
    auto spectra = std::make_shared<RoomSpectra>(&synth::room::RoomResponse::tail,
                                                 cache.empty() ? cache : cache / "rooms");
    EffectParts parts;
    parts.audio = [room, spectra](Sound& sound) {
      const Room place = room_of(room, sound, relative_listeners(*sound.object));
      const std::vector<Vec3>& listeners = place.listeners;
      // Reverberation is made of what the object radiates, not of its early reflections.
      const bool alone = sound.direct.empty();
      if (alone && sound.record != nullptr) record_room(*sound.record, room, place);
      std::vector<double> levels;
      std::vector<double> joins;
      std::vector<float> dry;
      for (std::size_t r = 0; r < sound.rows && r < listeners.size(); ++r) {
        const std::span<float> row = sound.row(r);
        synth::room::RoomOptions options =
            room_options(room, place, listeners[r], sound.sample_rate, row.size(), sound.seed);
        options.with_images = false;
        const RoomSpectra::Entry& entry = spectra->of(options);
        if (alone) spectra->take_air(entry, row);
        const std::span<float> heard =
            alone ? row : std::span(sound.direct).subspan(r * row.size(), row.size());
        dry.assign(heard.begin(), heard.end());
        spectra->convolver().add(dry, entry.spectrum, row);
        levels.push_back(entry.tail_db);
        joins.push_back(entry.join_db);
      }
      if (sound.record != nullptr) {
        sound.record->add("tail_level", std::span<const double>(levels), {levels.size()});
        sound.record->add("tail_join", std::span<const double>(joins), {joins.size()});
      }
    };
    return parts;
  };
  return effect;
}

}  // namespace

const Effect tail_effect = {
    .name = "tail",
    .description = "late reverberation of a room: noise with the prescribed decay in each octave",
    .key = "room",
    .stage = "audio",
    .read = read};

}  // namespace carillon::scene
