#pragma once

#include "core/config.hpp"

namespace carillon::scene {

/// The keys that every camera has, `width` and `height` [pixel] and `field_of_view` [rad]; what
/// they hold before is what they are without a key.
/// @throws ConfigError  out of range
void read_picture(core::ConfigNode& node, int& width, int& height, double& field_of_view);

}  // namespace carillon::scene
