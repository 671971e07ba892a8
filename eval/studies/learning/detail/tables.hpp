#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace carillon::eval::studies {

/// Share in percent with two digits, "-" for null.
std::string percent(const nlohmann::ordered_json& fraction);
/// "93.21 [90.10, 95.80]" of a summary with `mean` and `interval95`.
std::string with_interval(const nlohmann::ordered_json& summary);

/// A Markdown table, columns as wide as their widest cell; the first row is the header.
std::string markdown(const std::vector<std::vector<std::string>>& rows);

}  // namespace carillon::eval::studies
