#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

namespace carillon::core {

/// Says what came of something: `text` to a person, or `document` to a program, as is wanted.
using Tell = std::function<void(const std::string& text, const nlohmann::ordered_json& document)>;

}  // namespace carillon::core
