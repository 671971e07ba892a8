#pragma once

#include <optional>
#include <string>
#include <vector>

namespace carillon::eval::studies {

/// Sets of sounds that Sterling 2019, Tables 6.1 to 6.5, has accuracies of, with what is told apart
/// in them: `mn10o-geometry`.
std::vector<std::string> published_sets();

/// Accuracy of a method on one of these sets.
/// @param method  as known_methods() calls it
/// @return nothing where the tables have none
std::optional<double> published_accuracy(const std::string& set, const std::string& method);

}  // namespace carillon::eval::studies
