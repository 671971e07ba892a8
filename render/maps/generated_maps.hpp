#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "render/maps/surface_map.hpp"

namespace carillon::render::maps {

/// A map that is computed: its parameters and their defaults, lengths in metres, numbers of
/// columns, rows and waves as whole numbers.
struct GeneratedMap {
  std::string name;  ///< brick, grooves, pebbles, tiles, noise
  std::string description;
  std::map<std::string, double> defaults;
};
const std::vector<GeneratedMap>& generated_maps();

/// A relief that repeats without a seam, in detail about a texel fine.
/// @param parameters  in place of the defaults
/// @param texels      along the longer side, 16 to 4096 (grooves: rounded down to a whole number in
///                    each wave)
/// @param seed        of what is drawn (pebbles, noise, the unevenness of bricks)
/// @throws InputError  unknown name or parameter (with the nearest), values that cannot be
SurfaceMap generate_map(const std::string& name, const std::map<std::string, double>& parameters,
                        int texels, std::uint64_t seed);

}  // namespace carillon::render::maps
