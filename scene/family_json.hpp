#pragma once

#include <nlohmann/json.hpp>

#include "solvers/families/families.hpp"

namespace carillon::scene {

/// name, description, parameters [{name, low_m, high_m, meaning}]
nlohmann::json to_json(const solvers::families::Family& family);

}  // namespace carillon::scene
