#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/scoring/seed_answers.hpp"

namespace carillon::eval::scoring {

/// A number with so many digits after the point, "-" for one that is not finite.
std::string figure(double number, int digits);
/// Share in percent with two digits, "-" for NaN.
std::string percent(double fraction);
/// In percent, "93.21 [90.10, 95.80]"; "-" for nothing.
std::string with_interval(const std::optional<Estimate>& estimate);

/// A Markdown table, columns as wide as their widest cell; the first row is the header.
std::string markdown(const std::vector<std::vector<std::string>>& rows);

}  // namespace carillon::eval::scoring
