#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace carillon::core {

/// What may have been meant by a word that is none of these names, for the end of a message:
/// `; did you mean "x"?`, of several `; did you mean "x", "y" or "z"?`, or nothing. Those that
/// have the word between underscores, as "bell_bronze" has "bronze"; else the nearest by its
/// letters (core::nearest_name).
std::string did_you_mean(std::string_view word, const std::vector<std::string>& names);

}  // namespace carillon::core
