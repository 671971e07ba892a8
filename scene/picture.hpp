#pragma once

#include <string>

#include "core/config.hpp"

namespace carillon::scene {

/// The keys that every camera has, `width` and `height` [pixel] and `field_of_view` [rad]; what
/// they hold before is what they are without a key.
/// @throws ConfigError  out of range
void read_picture(core::ConfigNode& node, int& width, int& height, double& field_of_view);

/// What a check of an effect does that draws pictures.
/// @param key  of `node` that asks for them
/// @throws ConfigError  this program was built without them
void require_pictures(const core::ConfigNode& node, const std::string& key,
                      const std::string& effect);

}  // namespace carillon::scene
