#pragma once

#include <nlohmann/json.hpp>

#include "eval/features/extract_features.hpp"

namespace carillon::eval::features {

/// What was extracted, without the residual; docs/features.md names the fields. What is not known
/// is null.
nlohmann::json to_json(const FeatureSet& set);

}  // namespace carillon::eval::features
