#pragma once

#include <span>
#include <string>

#include "scene/scene.hpp"
#include "solvers/modes/modes.hpp"

namespace carillon::dataset::configuration {

/// Where models let modes of a band grow, and what will become of such modes: one sentence for the
/// plan and for whoever starts a build, before any object is solved. Objects of several materials
/// add their regions up, so that a mode of theirs need not be negative there.
/// @param choice  `error`, `clamp` or `drop`, as `negative_damping` has it
/// @return empty where no model is negative in the band
std::string negative_damping(std::span<const synth::material::Material> materials,
                             const solvers::modes::Band& band, const std::string& choice);

}  // namespace carillon::dataset::configuration
