#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "scene/solved_object.hpp"
#include "synth/damping/damping.hpp"

namespace carillon::scene {

/// Modes, certificate, solver and mesh of an object, as `carillon modes --json` prints them.
nlohmann::json to_json(const SolvedObject& object, const synth::damping::DecayRates& damping);

/// Why a set is empty, and which way the band would have to be widened.
std::string why_no_mode(const SolvedObject& object);

}  // namespace carillon::scene
