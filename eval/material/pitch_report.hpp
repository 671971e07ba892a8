#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "core/trace.hpp"
#include "eval/material/pitch_estimate.hpp"

namespace carillon::eval::material {

/// An estimate as --json prints it; docs/material-estimation.md names the fields. What is not
/// determined is null.
/// @param density  of the object [kg/m^3], where it is known
/// @param trace    stages that ran
nlohmann::json to_json(const PitchEstimate& estimate, const std::optional<double>& density,
                       const core::Trace& trace);

/// The same for people.
void print_estimate(const PitchEstimate& estimate, const std::optional<double>& density,
                    const core::Trace& trace);

}  // namespace carillon::eval::material
