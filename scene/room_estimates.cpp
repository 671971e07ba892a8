// What can be said of a scene's rooms before any sound is made: whether they are heard, and what
// their responses cost.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "scene/room_scene.hpp"
#include "synth/room/air_filter.hpp"

namespace carillon::scene {

using synth::room::OctaveValues;

namespace {

constexpr double heard_air_loss = 1;    ///< [dB]
constexpr double unheard_image = 1e-3;  ///< pressure against the direct sound

// Measured by scripts/bench room (docs/sound/room.md), at 44.1 kHz.
constexpr double seconds_per_image = 4e-5;
constexpr double seconds_per_tail_second = 0.02;
constexpr double seconds_per_sample = 2.6e-8;  ///< of a convolution

std::vector<Vec3> places_of(const Scene& scene) {
  std::vector<Vec3> places;
  for (const synth::modal::Listener& listener : scene.listeners)
    places.push_back(listener.position);
  return places;
}

/// Nothing that any wall reflects in any octave of the clip.
bool walls_reflect_nothing(const synth::room::WallAbsorption& walls, std::size_t octaves) {
  for (const OctaveValues& wall : walls) {
    for (std::size_t b = 0; b < octaves; ++b) {
      if (std::sqrt(1 - wall[b]) >= unheard_image) return false;
    }
  }
  return true;
}

/// How long after the direct sound the first reflection comes at the earliest, wherever the object
/// may be [s]. A wall at distances a and b of object and listener has r^2 = r0^2 + 4 a b. The
/// smallest room has the nearest walls.
double earliest_reflection(const RoomScene& room, const Scene& scene) {
  const Room place = typical_room(room, scene, false, places_of(scene));
  double earliest = std::numeric_limits<double>::infinity();
  for (const Vec3& listener : place.listeners) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool far : {false, true}) {
        const double margin = room.margin > 0 ? room.margin : 0.1 * place.size[axis];
        const double object = !room.source ? margin
                              : far        ? place.size[axis] - place.source[axis]
                                           : place.source[axis];
        double ear = object + (far ? -1 : 1) * listener[axis];
        if (room.dry) {
          ear = !room.listener ? margin
                : far          ? place.size[axis] - (*room.listener)[axis]
                               : (*room.listener)[axis];
        }
        ear = std::max(ear, 0.0);
        const double direct = listener.norm();
        const double way = std::sqrt(direct * direct + 4 * object * ear) - direct;
        earliest = std::min(earliest, way / synth::room::sound_speed(room.air));
      }
    }
  }
  return earliest;
}

/// Images up to an order: sum over k of 4 k^2 + 2.
double images_up_to(double order) {
  return (4 * order * order * order + 6 * order * order + 8 * order) / 3;
}

}  // namespace

bool air_is_heard(const RoomScene& room, const Scene& scene) {
  const std::size_t octaves = synth::room::octaves_below_nyquist(scene.audio.sample_rate);
  const std::vector<Vec3> listeners =
      room.dry ? typical_room(room, scene, true, {}).listeners : places_of(scene);
  return std::any_of(listeners.begin(), listeners.end(), [&](const Vec3& listener) {
    // Losses grow with frequency.
    const double highest =
        std::min(synth::room::octave_centres[octaves - 1], scene.audio.sample_rate / 2);
    return synth::room::air_loss(highest, listener.norm(), room.air) >= heard_air_loss;
  });
}

std::string why_no_reflection(const RoomScene& room, const Scene& scene) {
  if (room.order == 0) return "order 0: no image sources are asked for";
  const Room place = typical_room(room, scene, false, places_of(scene));
  if (walls_reflect_nothing(place.walls,
                            synth::room::octaves_below_nyquist(scene.audio.sample_rate))) {
    return "walls that reflect nothing";
  }
  const double first = earliest_reflection(room, scene);
  if (first >= scene.audio.seconds) {
    return fmt::format(
        "the first reflection comes {:.2g} s after the direct sound, beyond the clip's {:.2g} s",
        first, scene.audio.seconds);
  }
  return "";
}

namespace {

/// Rooms that a shape's sounds may draw: a shape is in one part, its strikes are in several, and
/// parts are pairs of both.
double rooms_of_a_shape(const RoomScene& room, const Scene& scene) {
  if (!room.drawn) return 1;
  return room.count * std::round(std::sqrt(static_cast<double>(scene.parts)));
}

/// Of one chain's spectra [byte]: those of every room that a shape's sounds may draw.
double memory_of_spectra(const RoomScene& room, const Scene& scene) {
  const double spectra = spectrum_bytes * static_cast<double>(scene.rendered_samples());
  return std::min(room_memory,
                  spectra * rooms_of_a_shape(room, scene) * static_cast<double>(scene.rows()));
}

}  // namespace

std::string asked_by_room(const std::string& key, const std::string& place, bool dry) {
  return fmt::format("{}: ({}){}", key, place, dry ? ", for the dry sound" : "");
}

std::string why_unheard(const Scene& scene) {
  const std::string reason = scene.unheard();
  return reason.empty() ? "" : reason + "; `room.input: dry` takes the dry sound";
}

std::optional<RoomScene> ask_for_room(core::ConfigNode& root, const Scene& scene,
                                      SceneEffect& effect) {
  if (!root.has("room")) {
    effect.reason_off = "no room:";
    return std::nullopt;
  }
  core::ConfigNode node = root.child("room");
  if (node.has("responses")) {
    effect.reason_off = fmt::format("room.responses: ({}) are measured", node.where("responses"));
    return std::nullopt;
  }
  RoomScene room = read_room(root, scene);
  effect.asked_by = asked_by_room("room", root.where("room"), room.dry);
  if (!room.dry) effect.reason_off = why_unheard(scene);
  effect.memory = memory_of_spectra(room, scene);
  return room;
}

double seconds_per_sound(const RoomScene& room, const Scene& scene, bool images) {
  const Room place = typical_room(room, scene, true, places_of(scene));
  const double rate = scene.audio.sample_rate / 44100;
  double seconds = 0;
  if (images) {
    // Of those that are asked for, as many as arrive within the clip.
    const double reach = synth::room::sound_speed(room.air) * scene.audio.seconds;
    const double within = 4 * std::numbers::pi / 3 * reach * reach * reach / place.size.prod();
    seconds = seconds_per_image * rate * std::min(images_up_to(room.order), within);
  } else {
    const OctaveValues rt60 = synth::room::eyring(
        place.size, synth::room::mean_absorption(place.size, place.walls), room.air);
    const double longest = *std::max_element(rt60.begin(), rt60.end());
    // The room's is the longest that may be drawn.
    const double drawn = room.rt60 ? 0.5 * (1 + room.rt60->low / room.rt60->high) : 1;
    seconds = seconds_per_tail_second * rate * std::min(1.5 * drawn * longest, scene.audio.seconds);
  }
  const auto strikes = static_cast<double>(scene.strikes_per_object() * scene.variants);
  const double convolution = seconds_per_sample * static_cast<double>(scene.rendered_samples());
  return convolution + seconds * std::min(1.0, room.count / std::max(1.0, strikes));
}

}  // namespace carillon::scene
