#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <optional>

#include "core/files.hpp"
#include "core/hdf5.hpp"
#include "synth/room/room.hpp"

namespace carillon::synth::room {

namespace {

using core::Hdf5Group;

OctaveValues octaves(const std::vector<double>& values) {
  OctaveValues result{};
  std::copy_n(values.begin(), std::min(values.size(), kOctaves), result.begin());
  return result;
}

std::optional<RoomResponse> load(const std::filesystem::path& path) {
  try {
    if (!std::filesystem::exists(path)) return std::nullopt;
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
  } catch (const std::exception& e) {
    spdlog::warn("a cached room response is computed again: {}", e.what());
    return std::nullopt;
  }
}

void store(const std::filesystem::path& path, const RoomResponse& response) {
  try {
    core::write_durably(path, [&response](const std::filesystem::path& temporary) {
      const Hdf5Group file = Hdf5Group::create_file(temporary);
      const auto write = [&file](const char* name, std::span<const double> values) {
        // An array without elements is left out.
        if (!values.empty()) file.write<double>(name, values, {values.size()});
      };
      write("air", response.air);
      write("images", response.images);
      write("tail", response.tail);
      write("rt60", response.rt60);
      write("level", response.level);
      file.write_attribute("tail_start_s", response.tail_start);
      file.write_attribute("tail_db", response.tail_db);
      file.write_attribute("join_db", response.join_db);
      file.flush();
    });
  } catch (const std::exception& e) {
    // The response itself is good; only the next run is slower.
    spdlog::warn("a room response could not be cached: {}", e.what());
  }
}

}  // namespace

RoomResponse cached_room_response(const RoomOptions& options, const std::filesystem::path& cache) {
  if (cache.empty()) return room_response(options);
  const std::filesystem::path path = cache / (room_key(options) + ".h5");
  if (auto response = load(path)) return std::move(*response);
  RoomResponse response = room_response(options);
  store(path, response);
  return response;
}

}  // namespace carillon::synth::room
