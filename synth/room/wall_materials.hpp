#pragma once

#include <string>
#include <vector>

#include "synth/room/room_acoustics.hpp"

namespace carillon::synth::room {

/// What a wall is made of or covered with.
struct WallMaterial {
  std::string name;
  std::string meaning;      ///< in words
  OctaveValues absorption;  ///< fraction of energy not reflected, 0 to 1
  std::string source;       ///< table, and the row of it
};

/// The rows of share/carillon/walls.yaml, which is within the library; read when they are first
/// asked for.
const std::vector<WallMaterial>& wall_materials();

/// @throws InputError  unknown; names the nearest
const WallMaterial& find_wall_material(const std::string& name);

}  // namespace carillon::synth::room
