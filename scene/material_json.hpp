#pragma once

#include <nlohmann/json.hpp>

#include "synth/material/material.hpp"

namespace carillon::scene {

/// Everything about a material: constants, damping (model, formula with its numbers, parameters)
/// source and group (where it has one). Rayleigh's parameters stand beside it under names with
/// units too.
nlohmann::json to_json(const synth::material::Material& material);

}  // namespace carillon::scene
