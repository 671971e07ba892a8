#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/config.hpp"

namespace carillon::dataset::configuration {

/// What a published dataset says of itself; nothing of it decides a value. Empty: not said.
struct About {
  std::string description, license, url, version, published, cite_as;
  std::vector<std::string> creators;
};

/// Reads `dataset:`.
/// @throws ConfigError
About read_about(core::ConfigNode node);

/// What was said, by the names of the keys; an empty object where nothing was.
nlohmann::json to_json(const About& about);
About about_from(const nlohmann::json& said);

/// Keys of `dataset:` without which Croissant holds a description for incomplete (1.1, "Required").
std::vector<std::string> missing_keys(const About& about);

}  // namespace carillon::dataset::configuration
