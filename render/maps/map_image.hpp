#pragma once

#include <filesystem>
#include <string>

#include "render/maps/surface_map.hpp"

namespace carillon::render::maps {

/// How an image becomes a map.
struct MapImage {
  double width = 0;  ///< of the whole image on the face [m]
  double depth = 0;  ///< of the deepest alpha (white, opaque) [m]; 0: a normal map
  bool repeats = true;
  bool green_down = false;  ///< the image's green axis points down (as Direct3D has it)
};

/// Reads a PNG of 8 or 16 bits a channel. RGB is the normal, (value - half) / half of each channel,
/// where half is 128 (or 32,768): 128 is exactly 0. RGBA with a depth is a relief, whose alpha says
/// how far a texel is cut in (0 at the face, full at `depth`); its surface is the one of the
/// depths, and a warning tells where RGB says something else.
/// @throws FileError   no such file, no PNG
/// @throws InputError  no colour, no alpha with a depth, normals that point into the surface, fewer
///                     than 4 texels, a width or depth that is not positive
SurfaceMap read_map(const std::filesystem::path& path, const MapImage& image);

/// Writes a map as it is read: RGB, or RGBA for a relief, 16 bits a channel.
/// @return what read_map() needs to read it again
/// @throws FileError
MapImage write_map(const std::filesystem::path& path, const SurfaceMap& map);

}  // namespace carillon::render::maps
