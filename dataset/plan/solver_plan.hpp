#pragma once

#include <nlohmann/json.hpp>

#include "dataset/configuration/configuration.hpp"

namespace carillon::dataset::plan {

/// What will solve the bodies of a build, and why: a list of {name, value, text, reason}; `value`
/// for programs (SI, null where it is chosen for each body), `text` for a person. Names: order,
/// element_size, max_elements, pitch_target, band, max_modes, eigen_solver, linear_solver,
/// memory_limit.
nlohmann::json plan_solver(const configuration::BuildConfig& config);

}  // namespace carillon::dataset::plan
