// The `room:` of a configuration, as far as its rooms are simulated.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "core/error.hpp"
#include "scene/detail/room_walls.hpp"
#include "scene/room_scene.hpp"
#include "synth/room/wall_materials.hpp"

namespace carillon::scene {

using core::ConfigNode;
using core::Dimension;
using synth::room::OctaveValues;

namespace {

/// One value for all octaves, or a list of 6 to 8 from 125 Hz on, the last for those above.
OctaveValues read_octaves(ConfigNode& node, const std::string& key, Dimension dimension) {
  OctaveValues values{};
  if (!node.is_list(key)) {
    values.fill(node.quantity(key, dimension));
    return values;
  }
  const std::vector<double> list = node.quantities(key, dimension);
  return core::at_key(node, key, [&] { return synth::room::octaves_of(list); });
}

/// A number or a list of octaves, or the name of a wall material.
OctaveValues read_absorption(ConfigNode& node, const std::string& key) {
  if (!node.is_list(key)) {
    const std::string word = node.text(key);
    if (!word.empty() && std::isalpha(static_cast<unsigned char>(word.front())) != 0) {
      return core::at_key(node, key,
                          [&] { return synth::room::find_wall_material(word).absorption; });
    }
  }
  const OctaveValues values = read_octaves(node, key, Dimension::none);
  for (const double a : values) {
    if (!(a >= 0 && a <= 1)) {
      node.fail(key, fmt::format("an absorption of {}", a),
                "it is the fraction of energy that a wall does not reflect: 0 to 1");
    }
  }
  return values;
}

/// @param key     of the room: absorption or walls
/// @param others  what walls that are not given are called in its mapping
synth::room::WallAbsorption read_walls(ConfigNode& room, const std::string& key,
                                       const std::string& others) {
  if (!room.is_mapping(key)) {
    return synth::room::same_on_all_walls(read_absorption(room, key));
  }
  ConfigNode walls = room.child(key);
  for (const auto& [place, name] : {std::pair("z0", "floor"), std::pair("z1", "ceiling")}) {
    if (walls.has(place)) walls.fail(place, fmt::format("this wall is called {}", name));
  }
  std::optional<OctaveValues> rest;
  if (walls.has(others)) rest = read_absorption(walls, others);
  synth::room::WallAbsorption absorption;
  for (std::size_t w = 0; w < synth::room::wall_count; ++w) {
    const char* name = synth::room::wall_names[w];
    if (walls.has(name)) {
      absorption[w] = read_absorption(walls, name);
    } else if (rest) {
      absorption[w] = *rest;
    } else {
      walls.fail("", fmt::format("no absorption of the wall {}", name),
                 fmt::format("give x0, x1, y0, y1, floor and ceiling, or {} for those that are "
                             "not given",
                             others));
    }
  }
  return absorption;
}

/// The one key that says how much a room reflects.
std::string reflecting_key(const ConfigNode& room) {
  std::string given;
  for (const char* key : {"absorption", "walls", "rt60"}) {
    if (!room.has(key)) continue;
    if (!given.empty()) {
      room.fail(key,
                fmt::format("{} and {} are both given; one follows from the other", given, key),
                "give one of absorption (of the walls, 0 to 1), walls (what they are made of) and "
                "rt60 (reverberation time)");
    }
    given = key;
  }
  if (given.empty()) {
    room.fail("", "neither absorption nor walls nor rt60 is given",
              "give absorption (of the walls, 0 to 1), walls (what they are made of: carillon list "
              "walls) or rt60 (reverberation time)");
  }
  return given;
}

std::vector<double> read_place(ConfigNode& room, const std::string& key) {
  if (room.is_list(key)) return room.quantities(key, Dimension::length, 3);
  room.choice(key, {"random"}, "random");
  return {};
}

/// Where object and listener are.
void read_places(ConfigNode& node, RoomScene& room) {
  if (const auto at = read_place(node, "source"); !at.empty()) room.source = Vec3(at.data());
  if (room.dry) {
    if (const auto at = read_place(node, "listener"); !at.empty()) room.listener = Vec3(at.data());
  } else if (node.has("listener")) {
    node.fail("listener", "goes with `input: dry`; pressure is heard at `listeners`",
              "positions of `listeners` are meant from the object's centre");
  }
  if (room.source && (room.listener || !room.dry)) return;
  room.margin = node.quantity("margin", Dimension::length, 0.0);
  if (!(room.margin >= 0)) node.fail("margin", "a distance from the walls is not negative");
}

/// A number or two, low and high, of 1 kHz; or a list of octaves.
void read_rt60(ConfigNode& node, const Scene& scene, RoomScene& room) {
  const bool octaves = node.is_list("rt60") && node.quantities("rt60", Dimension::time).size() != 2;
  if (octaves) {
    room.octave_rt60 = read_octaves(node, "rt60", Dimension::time);
  } else {
    room.rt60 = node.range("rt60", Dimension::time);
  }
  core::at_key(node, "rt60", [&] {
    const core::Range times = room.rt60.value_or(core::Range{});
    for (const bool largest : {false, true}) {
      walls_of(room, room_size(room, largest), scene.audio.sample_rate, times.low);
      walls_of(room, room_size(room, largest), scene.audio.sample_rate, times.high);
    }
  });
}

}  // namespace

bool read_dry_input(ConfigNode& room, const Scene& scene) {
  const bool dry = room.choice("input", {"radiated", "dry"}, "radiated") == "dry";
  if (dry && scene.runs("radiation")) {
    room.fail("input",
              "a room that acts on the dry sound has a listener of its own, but `listeners` are "
              "placed, who hear the radiated pressure",
              "remove `listeners`, switch radiation off, or write `input: radiated`");
  }
  return dry;
}

RoomScene read_room(ConfigNode& root, const Scene& scene) {
  ConfigNode node = root.child("room");
  RoomScene room;
  room.dry = read_dry_input(node, scene);
  room.size = node.ranges("dimensions", Dimension::length, 3);
  core::at_key(node, "dimensions", [&] {
    synth::room::check_room_size(room_size(room, false));
    synth::room::check_room_size(room_size(room, true));
  });
  read_places(node, room);
  room.air.temperature = node.quantity("temperature", Dimension::none, 20.0);
  room.air.humidity = node.quantity("humidity", Dimension::none, 0.5);
  core::at_key(node, "temperature", [&] {
    synth::room::sound_speed(synth::room::Air{room.air.temperature, 0.5});
  });
  core::at_key(node, "humidity", [&] { synth::room::sound_speed(room.air); });
  room.order = static_cast<int>(node.integer("image_order", 0, synth::room::highest_order, 3));
  room.count = static_cast<int>(node.integer("count", 1, 1000000, 20));

  if (const std::string key = reflecting_key(node); key != "rt60") {
    room.walls = read_walls(node, key, key == "walls" ? "others" : "walls");
  } else {
    read_rt60(node, scene, room);
  }
  const auto differs = [](const core::Range& range) { return range.low < range.high; };
  room.drawn = !room.source || (room.dry && !room.listener) ||
               std::any_of(room.size.begin(), room.size.end(), differs) ||
               (room.rt60 && differs(*room.rt60));
  if (!room.drawn) room.count = 1;
  std::vector<Vec3> listeners;
  for (const synth::modal::Listener& listener : scene.listeners)
    listeners.push_back(listener.position);
  const char* placed = room.listener ? "listener" : room.source ? "source" : "dimensions";
  core::at_key(node, placed, [&] { typical_room(room, scene, false, listeners); });
  return room;
}

}  // namespace carillon::scene
