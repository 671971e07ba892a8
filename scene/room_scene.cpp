#include "scene/room_scene.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/error.hpp"
#include "core/random.hpp"
#include "synth/room/wall_materials.hpp"

namespace carillon::scene {

using core::ConfigNode;
using core::Dimension;
using synth::room::octave_count;
using synth::room::OctaveValues;

namespace {

constexpr double listener_margin =
    0.01;  ///< of a listener to walls where places are drawn, of a side

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

Vec3 corner(const RoomScene& scene, bool largest) {
  Vec3 size;
  for (int i = 0; i < 3; ++i) {
    const core::Range& side = scene.size[static_cast<std::size_t>(i)];
    size[i] = largest ? side.high : side.low;
  }
  return size;
}

synth::room::WallAbsorption walls_of(const RoomScene& scene, const Vec3& size, double sample_rate) {
  if (scene.walls) return *scene.walls;
  if (scene.octave_rt60) {
    return synth::room::same_on_all_walls(synth::room::absorption_for(
        size, *scene.octave_rt60, scene.air, synth::room::octaves_below_nyquist(sample_rate)));
  }
  // One number is that of 1 kHz, where it is within the limits of air and absorption alone; walls
  // absorb alike at all octaves, and air makes the highest shorter.
  OctaveValues times;
  for (std::size_t b = 0; b < octave_count; ++b) {
    const auto limits = synth::room::reverberation_limits(size, b, scene.air);
    times[b] = b == 3 ? *scene.rt60 : std::clamp(*scene.rt60, limits.low, limits.high);
  }
  OctaveValues absorption;
  absorption.fill(synth::room::absorption_for(size, times, scene.air)[3]);
  return synth::room::same_on_all_walls(absorption);
}

/// Where the object may be so that it and its listeners are inside.
Eigen::AlignedBox3d places(const RoomScene& scene, const Vec3& size,
                           const std::vector<Vec3>& listeners) {
  const Vec3 margin = scene.margin > 0 ? Vec3::Constant(scene.margin) : Vec3(0.1 * size);
  Eigen::AlignedBox3d box(margin, size - margin);
  for (const Vec3& listener : listeners) {
    const Vec3 near = listener_margin * size;
    box = box.intersection(Eigen::AlignedBox3d(near - listener, size - near - listener));
  }
  if (box.isEmpty()) {
    throw core::InputError(
        fmt::format(
            "a room of {} has no place for the object, {:.3g} m from the walls, with all its "
            "listeners inside",
            synth::room::size_text(size), margin.minCoeff()),
        "make the room larger, or the margin or the listeners' distances smaller");
  }
  return box;
}

void check_places(const Vec3& size, const Vec3& source, const std::vector<Vec3>& listeners,
                  int order) {
  for (const Vec3& listener : listeners) {
    synth::room::check_room(size, source, source + listener, order);
  }
}

}  // namespace

RoomScene read_room(ConfigNode& root, const Scene& scene) {
  ConfigNode node = root.child("room");
  RoomScene room;
  room.size = node.ranges("dimensions", Dimension::length, 3);
  core::at_key(node, "dimensions", [&] {
    synth::room::check_room_size(corner(room, false));
    synth::room::check_room_size(corner(room, true));
  });
  if (node.is_list("source")) {
    const auto at = node.quantities("source", Dimension::length, 3);
    room.source = Vec3(at[0], at[1], at[2]);
  } else {
    node.choice("source", {"random"}, "random");
    room.margin = node.quantity("margin", Dimension::length, 0.0);
    if (!(room.margin >= 0)) node.fail("margin", "a distance from the walls is not negative");
  }
  room.air.temperature = node.quantity("temperature", Dimension::none, 20.0);
  room.air.humidity = node.quantity("humidity", Dimension::none, 0.5);
  core::at_key(node, "temperature", [&] {
    synth::room::sound_speed(synth::room::Air{room.air.temperature, 0.5});
  });
  core::at_key(node, "humidity", [&] { synth::room::sound_speed(room.air); });
  room.order = static_cast<int>(node.integer("image_order", 0, synth::room::highest_order, 3));
  room.drawn = !room.source || std::any_of(room.size.begin(), room.size.end(),
                                           [](auto side) { return side.low < side.high; });
  room.count = static_cast<int>(node.integer("count", 1, 1000000, 20));
  if (!room.drawn) room.count = 1;

  if (const std::string key = reflecting_key(node); key != "rt60") {
    room.walls = read_walls(node, key, key == "walls" ? "others" : "walls");
  } else {
    const OctaveValues times = read_octaves(node, "rt60", Dimension::time);
    if (node.is_list("rt60")) {
      room.octave_rt60 = times;
    } else {
      room.rt60 = times[0];
    }
    core::at_key(node, "rt60", [&] {
      walls_of(room, corner(room, false), scene.audio.sample_rate);
      walls_of(room, corner(room, true), scene.audio.sample_rate);
    });
  }
  std::vector<Vec3> listeners;
  for (const synth::modal::Listener& listener : scene.listeners)
    listeners.push_back(listener.position);
  core::at_key(node, room.source ? "source" : "dimensions",
               [&] { typical_room(room, scene, false, listeners); });
  return room;
}

Room typical_room(const RoomScene& scene, const Scene& audio, bool largest,
                  const std::vector<Vec3>& listeners) {
  Room room;
  room.size = corner(scene, largest);
  room.source = scene.source ? *scene.source : places(scene, room.size, listeners).center();
  check_places(room.size, room.source, listeners, scene.order);
  room.walls = walls_of(scene, room.size, audio.audio.sample_rate);
  return room;
}

std::vector<Room> rooms_at_the_edges(const RoomScene& scene, const Scene& audio, bool largest,
                                     const std::vector<Vec3>& listeners) {
  if (scene.source) return {};
  const Room middle = typical_room(scene, audio, largest, listeners);
  const Eigen::AlignedBox3d box = places(scene, middle.size, listeners);
  std::vector<Room> rooms(8, middle);
  for (int corner = 0; corner < 8; ++corner) {
    rooms[static_cast<std::size_t>(corner)].source =
        box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
  }
  return rooms;
}

Room room_of(const RoomScene& scene, const Sound& sound, const std::vector<Vec3>& listeners) {
  core::RandomStream choice(sound.seed, sound.id, "room.choice");
  const auto count = static_cast<std::uint64_t>(scene.count);
  const std::uint64_t number = sound.part * count + choice.index(count);
  Room room;
  room.number = static_cast<std::int64_t>(number);
  core::RandomStream sides(sound.seed, number, "room.size");
  for (int i = 0; i < 3; ++i) {
    const core::Range& side = scene.size[static_cast<std::size_t>(i)];
    room.size[i] = sides.uniform(side.low, side.high);
  }
  if (scene.source) {
    room.source = *scene.source;
  } else {
    const Eigen::AlignedBox3d box = places(scene, room.size, listeners);
    core::RandomStream place(sound.seed, number, "room.source");
    for (int i = 0; i < 3; ++i) room.source[i] = place.uniform(box.min()[i], box.max()[i]);
  }
  check_places(room.size, room.source, listeners, scene.order);
  room.walls = walls_of(scene, room.size, sound.sample_rate);
  return room;
}

synth::room::RoomOptions room_options(const RoomScene& scene, const Room& room,
                                      const Vec3& listener, double sample_rate, std::size_t count,
                                      std::uint64_t seed) {
  synth::room::RoomOptions options;
  options.size = room.size;
  options.source = room.source;
  options.listener = room.source + listener;
  options.walls = room.walls;
  options.air = scene.air;
  options.order = scene.order;
  options.sample_rate = sample_rate;
  options.count = count;
  options.seed = seed;
  return options;
}

std::vector<Vec3> relative_listeners(const RingingObject& object) {
  std::vector<Vec3> relative;
  for (const synth::modal::Listener& listener : object.listeners) {
    const Vec3 from_centre = listener.position - object.centre;
    relative.emplace_back((from_centre * 1e9).array().round() / 1e9);
  }
  return relative;
}

void record_room(core::Columns& record, const RoomScene& scene, const Room& room) {
  record.add("room", room.number);
  record.add("room_size", std::span<const double>(room.size.data(), 3), {3});
  record.add("room_source", std::span<const double>(room.source.data(), 3), {3});
  const OctaveValues rt60 = synth::room::eyring(
      room.size, synth::room::mean_absorption(room.size, room.walls), scene.air);
  record.add("room_rt60", std::span<const double>(rt60), {octave_count});
}

const RoomSpectra::Entry& RoomSpectra::of(const synth::room::RoomOptions& options) {
  const std::string key = synth::room::room_key(options);
  const auto found = entries_.find(key);
  if (found != entries_.end()) return found->second;
  if (static_cast<double>(bytes_) > room_memory) {
    entries_.clear();
    bytes_ = 0;
  }
  const synth::room::RoomResponse response = synth::room::cached_room_response(options, cache_);
  Entry entry;
  entry.spectrum = convolver_.prepare(response.*part_, options.count);
  entry.tail_db = response.tail_db;
  entry.join_db = response.join_db;
  bytes_ += entry.spectrum.values.size() * sizeof(entry.spectrum.values[0]);
  if (!response.air.empty()) {
    entry.air = convolver_.prepare(response.air, options.count);
    bytes_ += entry.air->values.size() * sizeof(entry.air->values[0]);
  }
  return entries_.emplace(key, std::move(entry)).first->second;
}

void RoomSpectra::take_air(const Entry& entry, std::span<float> row) {
  if (!entry.air) return;
  const std::vector<float> before(row.begin(), row.end());
  std::fill(row.begin(), row.end(), 0.0F);
  convolver_.add(before, *entry.air, row);
}

}  // namespace carillon::scene
