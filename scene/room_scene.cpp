#include "scene/room_scene.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/random.hpp"
#include "scene/detail/room_walls.hpp"

namespace carillon::scene {

using synth::room::octave_count;
using synth::room::OctaveValues;

Vec3 room_size(const RoomScene& scene, bool largest) {
  Vec3 size;
  for (int i = 0; i < 3; ++i) {
    const core::Range& side = scene.size[static_cast<std::size_t>(i)];
    size[i] = largest ? side.high : side.low;
  }
  return size;
}

synth::room::WallAbsorption walls_of(const RoomScene& scene, const Vec3& size, double sample_rate,
                                     double rt60) {
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
    times[b] = b == 3 ? rt60 : std::clamp(rt60, limits.low, limits.high);
  }
  OctaveValues absorption;
  absorption.fill(synth::room::absorption_for(size, times, scene.air)[3]);
  return synth::room::same_on_all_walls(absorption);
}

namespace {

constexpr double listener_margin =
    0.01;  ///< of a listener to walls where places are drawn, of a side
/// Drawn places of object and listener are so far from each other, or a quarter of the diagonal of
/// where they may be [m].
constexpr double nearest_listener = 0.5;

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

void check_places(const Room& room, int order) {
  for (const Vec3& listener : room.listeners) {
    synth::room::check_room(room.size, room.source, room.source + listener, order);
  }
}

double longest_rt60(const RoomScene& scene) {
  return scene.rt60 ? scene.rt60->high : 0;
}

Vec3 farthest_corner(const Eigen::AlignedBox3d& box, const Vec3& place) {
  return (place.array() < box.center().array()).select(box.max(), box.min());
}

/// A drawn place of object or listener, far enough from the other one.
Vec3 draw_place(const Eigen::AlignedBox3d& box, const std::optional<Vec3>& other,
                core::RandomStream& random) {
  constexpr int tries = 1000;
  const double nearest = std::min(nearest_listener, 0.25 * box.diagonal().norm());
  for (int i = 0; i < tries; ++i) {
    Vec3 place;
    for (int axis = 0; axis < 3; ++axis) {
      place[axis] = random.uniform(box.min()[axis], box.max()[axis]);
    }
    if (!other || (place - *other).norm() >= nearest) return place;
  }
  return farthest_corner(box, *other);
}

/// Draws what is not given of the places of a room for dry sounds.
void place_dry(const RoomScene& scene, std::uint64_t seed, std::uint64_t number, Room& room) {
  std::optional<Vec3> source = scene.source;
  std::optional<Vec3> listener = scene.listener;
  if (!source || !listener) {
    const Eigen::AlignedBox3d box = places(scene, room.size, {});
    core::RandomStream of_source(seed, number, "room.source");
    core::RandomStream of_listener(seed, number, "room.listener");
    if (!source) source = draw_place(box, listener, of_source);
    if (!listener) listener = draw_place(box, source, of_listener);
  }
  room.source = *source;
  room.listeners = {*listener - *source};
}

/// Object and listener as far from each other as dry sounds may have them, the object in a corner
/// of where it may be.
void place_dry_far(const RoomScene& scene, const Vec3& source_corner, Room& room) {
  if (scene.source && scene.listener) {
    room.source = *scene.source;
    room.listeners = {*scene.listener - room.source};
    return;
  }
  const Eigen::AlignedBox3d box = places(scene, room.size, {});
  room.source = scene.source     ? *scene.source
                : scene.listener ? farthest_corner(box, *scene.listener)
                                 : source_corner;
  room.listeners = {(scene.listener ? *scene.listener : farthest_corner(box, room.source)) -
                    room.source};
}

}  // namespace

Room typical_room(const RoomScene& scene, const Scene& audio, bool largest,
                  const std::vector<Vec3>& listeners) {
  Room room;
  room.size = room_size(scene, largest);
  if (scene.dry) {
    place_dry_far(scene, Vec3(places(scene, room.size, {}).min()), room);
  } else {
    room.source = scene.source ? *scene.source : places(scene, room.size, listeners).center();
    room.listeners = listeners;
  }
  check_places(room, scene.order);
  room.walls = walls_of(scene, room.size, audio.audio.sample_rate, longest_rt60(scene));
  return room;
}

std::vector<Room> rooms_at_the_edges(const RoomScene& scene, const Scene& audio, bool largest,
                                     const std::vector<Vec3>& listeners) {
  if (scene.source) return {};
  const Room middle = typical_room(scene, audio, largest, listeners);
  const Eigen::AlignedBox3d box =
      places(scene, middle.size, scene.dry ? std::vector<Vec3>{} : listeners);
  std::vector<Room> rooms(8, middle);
  for (int corner = 0; corner < 8; ++corner) {
    Room& room = rooms[static_cast<std::size_t>(corner)];
    const Vec3 place = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    if (scene.dry) {
      place_dry_far(scene, place, room);
    } else {
      room.source = place;
    }
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
  if (scene.dry) {
    place_dry(scene, sound.seed, number, room);
  } else {
    core::RandomStream place(sound.seed, number, "room.source");
    room.source = scene.source
                      ? *scene.source
                      : draw_place(places(scene, room.size, listeners), std::nullopt, place);
    room.listeners = listeners;
  }
  check_places(room, scene.order);
  double rt60 = 0;
  if (scene.rt60) {
    core::RandomStream time(sound.seed, number, "room.rt60");
    rt60 = time.uniform(scene.rt60->low, scene.rt60->high);
  }
  room.walls = walls_of(scene, room.size, sound.sample_rate, rt60);
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
  if (scene.dry) {
    const Vec3 listener = room.source + room.listeners.front();
    record.add("room_listener", std::span<const double>(listener.data(), 3), {3});
  }
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
