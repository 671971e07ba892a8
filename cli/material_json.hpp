#pragma once

#include <nlohmann/json.hpp>

#include "synth/material.hpp"

namespace carillon::cli {

/// Everything about a material: constants, damping (model, formula with its numbers, parameters)
/// and source. Rayleigh's parameters stand beside it under names with units too.
nlohmann::json to_json(const synth::Material& material);

}  // namespace carillon::cli
