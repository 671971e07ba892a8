#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene.hpp"
#include "synth/room/room.hpp"
#include "synth/signal/convolution.hpp"

namespace carillon::scene {

/// The `room:` of a configuration: a pool of shoebox rooms for each part of the data set.
struct RoomScene {
  std::vector<core::Range> size;  ///< of the sides [m], 3
  std::optional<Vec3> source;     ///< where objects stand [m]; none: drawn for each room
  std::optional<Vec3> listener;   ///< of dry sounds [m]; none: drawn for each room
  double margin = 0;              ///< of drawn places to the walls [m]; 0: a tenth of a side
  std::optional<synth::room::WallAbsorption> walls;
  std::optional<core::Range> rt60;  ///< at 1 kHz, by walls that absorb alike at all octaves [s]
  std::optional<synth::room::OctaveValues> octave_rt60;  ///< [s]
  synth::room::Air air;
  int order = 3;
  int count = 20;     ///< rooms of a part's pool; 1 where nothing is drawn
  bool drawn = true;  ///< rooms differ; else all parts have the same one
  bool dry = false;   ///< they act on the dry sound, heard by a listener of their own
};

/// One room of a pool.
struct Room {
  std::int64_t number = 0;  ///< from 0; rooms of different parts have different numbers
  Vec3 size;
  Vec3 source;
  std::vector<Vec3> listeners;  ///< from the source [m]: the scene's, or of dry sounds the room's
  synth::room::WallAbsorption walls;
};

/// Reads `room.input`: whether the room acts on the dry sound, not on the pressure at listeners.
/// @throws ConfigError  on the dry sound while the scene has pressure at listeners
bool read_dry_input(core::ConfigNode& room, const Scene& scene);

/// "room: (kitchen.yaml:12)", and whether it acts on the dry sound.
std::string asked_by_room(const std::string& key, const std::string& place, bool dry);

/// Scene::unheard(), with what would do without listeners.
std::string why_unheard(const Scene& scene);

/// Reads `room`, which must be there, of simulated rooms.
/// The smallest room must hold the object and the scene's listeners.
/// @throws ConfigError
RoomScene read_room(core::ConfigNode& root, const Scene& scene);

/// A room of the pools at its largest or the smallest size and its longest reverberation, the
/// object in the middle of where it may be; of dry sounds, object and listener as far from each
/// other as they may be drawn.
/// @param listeners  from the object's centre [m]; dry sounds have the room's own
/// @throws InputError  no place for object and listeners; names the room's size
Room typical_room(const RoomScene& scene, const Scene& audio, bool largest,
                  const std::vector<Vec3>& listeners);

/// The same with the object in each corner of where it may be: that is where images of any order
/// are nearest (their distances are linear or constant in each coordinate). Of dry sounds, a drawn
/// listener is in the opposite corner.
std::vector<Room> rooms_at_the_edges(const RoomScene& scene, const Scene& audio, bool largest,
                                     const std::vector<Vec3>& listeners);

/// The room of a sample: which of its part's pool is keyed by (seed, id, "room.choice"), and what
/// the room is by (seed, its number), so that it is the same in every sample.
/// @param listeners  as typical_room()
/// @throws InputError  no place for object and listeners; names the room's size
Room room_of(const RoomScene& scene, const Sound& sound, const std::vector<Vec3>& listeners);

/// Options of the response of one listener in a room.
synth::room::RoomOptions room_options(const RoomScene& scene, const Room& room,
                                      const Vec3& listener, double sample_rate, std::size_t count,
                                      std::uint64_t seed);

/// An object's listeners from its centre, to a nanometre: equal for objects that lie elsewhere.
std::vector<Vec3> relative_listeners(const RingingObject& object);

/// Whether air takes a decibel or more from the direct sound of a listener, in an octave of which
/// the clip has the centre.
bool air_is_heard(const RoomScene& room, const Scene& scene);

/// Why no early reflection of the scene's rooms is heard (walls reflect nothing, or the first one
/// comes after the clip, wherever the object may be drawn); empty when one may be.
std::string why_no_reflection(const RoomScene& room, const Scene& scene);

/// What the effects of a simulated room have in common: reads `room`, and fills in what asks for
/// the effect, why it is off where nothing can be heard, and its memory.
/// @return none without `room`, or where its responses are measured
/// @throws ConfigError
std::optional<RoomScene> ask_for_room(core::ConfigNode& root, const Scene& scene,
                                      SceneEffect& effect);

/// Estimated cost of one sound and row: the convolution, and the response's making, shared by the
/// samples that may draw the same room. A shape's own strikes, in all its materials and sizes, are
/// all that is known of them here, and one pool stands for those of all parts: what other parts add
/// to it, the responses that shapes of the same part find in the cache take away.
/// @param images  of the early reflections; else of the tail
double seconds_per_sound(const RoomScene& room, const Scene& scene, bool images);

/// Spectra that one chain keeps at the most [byte].
inline constexpr double room_memory = 256.0 * 1024 * 1024;
/// Of a response's spectrum, for each sample of a clip [byte]: a complex number for each sample of
/// a clip that is padded to twice its length, and for every other one of what air takes from the
/// direct sound, which is short.
inline constexpr double spectrum_bytes = 24;

/// Adds the columns `room`, `room_size`, `room_source` and `room_rt60` of a sample, and of a dry
/// one `room_listener`.
void record_room(core::Columns& record, const RoomScene& scene, const Room& room);

/// Spectra of responses that were made before, up to 256 MiB of them.
class RoomSpectra {
 public:
  struct Entry {
    std::optional<synth::signal::ResponseSpectrum> air;  ///< on the direct way; none: takes nothing
    synth::signal::ResponseSpectrum spectrum;
    double tail_db = 0;
    double join_db = 0;
  };
  /// @param part   which part of a response is heard
  /// @param cache  folder of responses; empty: none
  RoomSpectra(std::vector<double> synth::room::RoomResponse::*part, std::filesystem::path cache)
      : part_(part), cache_(std::move(cache)) {}
  const Entry& of(const synth::room::RoomOptions& options);
  synth::signal::Convolver& convolver() { return convolver_; }
  /// Takes from a direct sound what air takes on its way.
  void take_air(const Entry& entry, std::span<float> row);

 private:
  std::vector<double> synth::room::RoomResponse::*part_;
  std::filesystem::path cache_;
  synth::signal::Convolver convolver_;
  std::map<std::string, Entry> entries_;
  std::size_t bytes_ = 0;
};

}  // namespace carillon::scene
