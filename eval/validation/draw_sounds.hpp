#pragma once

#include <cstddef>
#include <vector>

#include "core/random.hpp"

namespace carillon::eval::validation {

/// Sounds for one fit: an object is drawn from those that have enough of them, and of it `count`
/// different sounds.
/// @param objects  sounds of each object, by any numbers
/// @return in the order they were drawn; empty where no object has so many
std::vector<std::size_t> draw_sounds(const std::vector<std::vector<std::size_t>>& objects,
                                     std::size_t count, core::RandomStream& random);

}  // namespace carillon::eval::validation
