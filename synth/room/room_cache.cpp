#include <algorithm>
#include <span>

#include "core/cached.hpp"
#include "core/hdf5.hpp"
#include "synth/room/room.hpp"

namespace carillon::synth::room {

namespace {

using core::Hdf5Group;

OctaveValues octaves(const std::vector<double>& values) {
  OctaveValues result{};
  std::copy_n(values.begin(), std::min(values.size(), octave_count), result.begin());
  return result;
}

RoomResponse read(const std::filesystem::path& path) {
  const Hdf5Group file = Hdf5Group::open_file(path);
  RoomResponse response;
  if (file.has("air")) response.air = file.read<double>("air");
  if (file.has("images")) response.images = file.read<double>("images");
  if (file.has("tail")) response.tail = file.read<double>("tail");
  response.rt60 = octaves(file.read<double>("rt60"));
  response.level = octaves(file.read<double>("level"));
  response.tail_start = file.number_attribute("tail_start_s");
  response.tail_db = file.number_attribute("tail_db");
  response.join_db = file.number_attribute("join_db");
  return response;
}

void write(const std::filesystem::path& path, const RoomResponse& response) {
  const Hdf5Group file = Hdf5Group::create_file(path);
  const auto list = [&file](const char* name, std::span<const double> values) {
    // An array without elements is left out.
    if (!values.empty()) file.write<double>(name, values, {values.size()});
  };
  list("air", response.air);
  list("images", response.images);
  list("tail", response.tail);
  list("rt60", response.rt60);
  list("level", response.level);
  file.write_attribute("tail_start_s", response.tail_start);
  file.write_attribute("tail_db", response.tail_db);
  file.write_attribute("join_db", response.join_db);
  file.flush();
}

}  // namespace

RoomResponse cached_room_response(const RoomOptions& options, const std::filesystem::path& cache) {
  if (cache.empty()) return room_response(options);
  return core::cached<RoomResponse>(cache, room_key(options) + ".h5", read, write,
                                    [&] { return room_response(options); });
}

}  // namespace carillon::synth::room
