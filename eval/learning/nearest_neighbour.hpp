#pragma once

#include <cstdint>
#include <vector>

#include "eval/learning/training.hpp"

namespace carillon::eval {

/// Answers of the k nearest training samples, by Euclidean distance of all values of all senses
/// together.
/// @param rows  that are asked for, ascending
/// @return of each row the share of its neighbours in each class, rows x classes; where classes
/// have
///         equal shares, that of the nearest among them is raised by half of one neighbour
/// @note Collective on the ranks.
std::vector<float> ask_neighbours(const Method& method, SampleSource& source,
                                  const LabelledSamples& samples,
                                  const std::vector<std::uint32_t>& rows,
                                  const LearningRanks& ranks);

}  // namespace carillon::eval
