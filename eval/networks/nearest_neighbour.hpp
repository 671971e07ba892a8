#pragma once

#include <cstdint>
#include <vector>

#include "eval/networks/training.hpp"

namespace carillon::eval::networks {

/// Answers of the k nearest training samples, by Euclidean distance of all values of all modalities
/// together.
/// @param rows  that are asked for, ascending
/// @return of each row the fraction of its neighbours in each class, rows x classes; where classes
///         have equal shares, that of the nearest among them is raised by half of one neighbour
/// @note Collective on the ranks.
std::vector<float> ask_neighbours(const learning::Method& method, learning::SampleSource& source,
                                  const learning::LabelledSamples& samples,
                                  const std::vector<std::uint32_t>& rows,
                                  const LearningRanks& ranks);

}  // namespace carillon::eval::networks
