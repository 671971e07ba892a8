#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/numbers.hpp"
#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::damping {

/// Numbers of a fitted damping model under their names, and their intervals under `confidence95`,
/// null for an end that the data do not bound.
/// @param confidence95  one for each number; empty: none are told
nlohmann::json alphas_json(const synth::damping::DampingModel& model,
                           std::span<const core::Range> confidence95);

/// "95 %: 1.2 to 3.4"; an end that the data do not bound is "any".
std::string interval_text(const core::Range& interval);

}  // namespace carillon::eval::damping
