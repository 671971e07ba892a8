#pragma once

#include <string>
#include <vector>

namespace carillon::eval::scoring {

/// The first three, and how many more there are, for a message.
std::string first_few(const std::vector<std::string>& all);

}  // namespace carillon::eval::scoring
