#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "synth/room/image_sources.hpp"
#include "synth/room/reverberant_tail.hpp"
#include "synth/room/room_acoustics.hpp"

namespace carillon::synth::room {

/// A shoebox room from (0, 0, 0) to `size`, a source and a listener in it.
struct RoomOptions {
  Eigen::Vector3d size = {5, 4, 3};  ///< [m]
  Eigen::Vector3d source = {1, 1, 1};
  Eigen::Vector3d listener = {2, 2, 1.5};
  WallAbsorption walls{};
  Air air;
  int order = 3;  ///< highest order of image sources
  double sample_rate = 44100;
  std::size_t count = 44100;  ///< samples that can be heard: the length of the clips
  std::uint64_t seed = 0;     ///< the tail's noise is keyed by it and by everything above but count
  bool with_images = true;    ///< whether that part is wanted; the other is the same without it
  bool with_tail = true;
};

/// What arrives after the direct sound, which is 1 at sample 0 and in neither part: pressure at the
/// listener is d + d * (images + tail) with d = direct * air, where `direct` has its 1/r and its
/// time of flight already. Walls that absorb everything leave images and tail silent.
struct RoomResponse {
  std::vector<double> air;  ///< on the direct way; empty: takes nothing, see air_response
  std::vector<double> images;
  std::vector<double> tail;  ///< empty: inaudible (see tail_db), or after the end of the clip
  OctaveValues rt60{};       ///< by Eyring's formula [s]; 0 in octaves above half the sample rate
  OctaveValues level{};      ///< tail against the diffuse field, by energy; see TailPlan
  double tail_start = 0;     ///< after the direct sound [s]
  double tail_db = 0;        ///< energy of the tail's loudest octave against the direct sound [dB]
  double join_db = 0;        ///< largest step left at the join, see TailPlan::join_db
};

/// Equal options give equal responses, bit for bit.
/// @throws InputError  a source or a listener outside the room or on a wall, or both at one point;
///                     an impossible size, absorption, air, order or rate
RoomResponse room_response(const RoomOptions& options);

/// Plan of the tail alone: when it starts and how loud it is.
/// @throws InputError  as room_response
TailPlan room_tail_plan(const RoomOptions& options);

/// 64 hexadecimal digits of everything a response depends on.
std::string room_key(const RoomOptions& options);

/// The same, read from `cache`/KEY.h5 when it is there, else computed and stored. A file that
/// cannot be read or written only costs time.
/// @param cache  folder; empty: none
RoomResponse cached_room_response(const RoomOptions& options, const std::filesystem::path& cache);

}  // namespace carillon::synth::room
