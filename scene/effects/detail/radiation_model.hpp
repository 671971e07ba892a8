#pragma once

#include <string>

#include "core/config.hpp"

namespace carillon::scene {

/// `radiation.model`, which also decides whether an object can jump.
inline std::string read_radiation_model(core::ConfigNode& radiation) {
  return radiation.choice("model", {"equivalent_sources", "monopole", "rayleigh_integral", "off"},
                          "equivalent_sources");
}

}  // namespace carillon::scene
