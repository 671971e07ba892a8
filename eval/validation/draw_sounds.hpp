#pragma once

#include <cstddef>
#include <vector>

#include "core/random.hpp"

namespace carillon::eval::validation {

/// Sounds for one fit: a body is drawn from those that have enough of them, and of it `count`
/// different sounds.
/// @param bodies  sounds of each body, by any numbers
/// @return in the order they were drawn; empty where no body has so many
std::vector<std::size_t> draw_sounds(const std::vector<std::vector<std::size_t>>& bodies,
                                     std::size_t count, core::RandomStream& random);

}  // namespace carillon::eval::validation
