#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/vectors.hpp"
#include "dataset/check/folder.hpp"

namespace carillon::dataset::check {

/// What the checks of splits need of one stored sample.
struct Row {
  std::string key, shape, material, split_shape, split_strike;
  std::uint64_t id = 0;
  double size = 1;
  std::int64_t strike = 0;           ///< or simulation
  bool simulation = false;           ///< of a scene that moves; its shape is itself
  std::vector<std::string> played;   ///< shapes of a simulation's objects
  Vec3 point = Vec3::Zero();         ///< struck, on the object at size 1 [m]
  std::optional<std::int64_t> room;  ///< number
  std::string room_text;             ///< its size, place and reverberation
  std::string response;              ///< room_response
  std::string noise;                 ///< noise_source
};

/// @param tasks  whose shards can be read
/// @throws FileError
std::vector<Row> read_rows(const DatasetFolder& folder, const std::vector<std::size_t>& tasks);

/// Keys and ids: each once, of their own parts, and those that the plan has.
Finding check_ids(const DatasetFolder& folder, const std::vector<Row>& rows);

}  // namespace carillon::dataset::check
