#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "dataset/sweep/sweep.hpp"

namespace carillon::dataset::sweep {

/// One row per variant: its folder, the swept keys' values, then the fields of `rows`.
/// @param rows  of the variants, objects with the same keys; null values are empty fields
std::string csv_table(const Sweep& sweep, const std::vector<nlohmann::ordered_json>& rows);

/// The same as JSON: {name, mode, keys, variants: [{variant, values, set, ...}]}.
nlohmann::ordered_json json_table(const std::string& name, const Sweep& sweep,
                                  const std::vector<nlohmann::ordered_json>& rows);

/// For a person: columns that are empty in every row are left out.
std::string text_table(const Sweep& sweep, const std::vector<nlohmann::ordered_json>& rows);

}  // namespace carillon::dataset::sweep
