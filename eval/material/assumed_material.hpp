#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/audio.hpp"
#include "eval/features/extract_features.hpp"
#include "eval/material/estimate_material.hpp"
#include "solvers/modes/modes.hpp"
#include "synth/material/material.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::eval::material {

/// What an object is taken to be of while its material is sought: its modes are solved once and
/// rescaled. Without damping.
/// @param named  a preset or constants, as parse_material() takes them; "": 70 GPa and
///               2500 kg/m^3, which glass and most metals are near to
/// @throws InputError  no Poisson's ratio, or an unphysical material
synth::material::Material assumed_material(const std::string& named,
                                           const std::optional<double>& poisson_ratio,
                                           const std::optional<double>& density);

/// An impulse of 1 N s on the point of the surface that is nearest to `at`.
/// @param direction  of the force, of any length; none: inward along the normal
synth::modal::Strike unit_strike(const solvers::modes::Modes& modes, const Vec3& at,
                                 const std::optional<Vec3>& direction);

/// An estimate as a clip of the recording's length, its strike at the recording's onset.
/// @param samples  of the recording, and `set` what was extracted from it
/// @param modes    of the assumed material, whose specific modulus is `assumed_modulus`
///                 [m^2/s^2]
core::AudioClip resynthesis(std::span<const double> samples, const features::FeatureSet& set,
                            const solvers::modes::Modes& modes, synth::modal::Strike strike,
                            const Candidate& estimate, double assumed_modulus, HeardMotion motion);

}  // namespace carillon::eval::material
