#pragma once

#include <span>

#include "eval/learning/method.hpp"

namespace carillon::eval::learning {

/// Classifiers that a configuration can name without saying what they are: those of Sterling 2019,
/// Tables 6.1 to 6.5, and with images and touch beside them.
std::span<const Method> known_methods();

}  // namespace carillon::eval::learning
