#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/config.hpp"
#include "render/maps/map_image.hpp"

namespace carillon::scene::motion {

/// `texture:` of a body or of the ground.
struct TextureConfig {
  std::string map;                           ///< a generated one's name, or "" for an image
  std::string image;                         ///< path
  std::map<std::string, double> parameters;  ///< of a generated map
  int texels = 512;                          ///< likewise
  render::maps::MapImage options;            ///< of an image
  bool normals = false;                      ///< a relief is made a normal map
  char axis = 'z';                           ///< the face looks along this axis of the body
  bool towards_plus = true;                  ///< its outward normal does
};

/// `texture:` of a body or the ground.
/// @param has_faces  whether `face` says on which side it lies; the ground has one
/// @throws ConfigError  keys that cannot be, an image that cannot be read
std::optional<TextureConfig> read_texture(core::ConfigNode& parent, const std::string& file_name,
                                          bool has_faces);

}  // namespace carillon::scene::motion
