#pragma once

#include <span>
#include <vector>

#include "core/random.hpp"
#include "eval/classification/intervals.hpp"

namespace carillon::eval::classification {

/// What classifiers answered for one set of samples: of each seed the class that each was taken
/// for.
struct AnsweredSamples {
  TestedSamples tested;
  std::span<const std::vector<std::size_t>> predicted;
};

/// Norms of `confusion_difference` between two sets whose classifiers err alike.
struct NormByChance {
  double mean = 0;  ///< NaN where no class is in both sets
  double max = 0;   ///< 95 % of the draws are within it
};

/// How far two patterns of errors are apart by chance alone: few samples of a class make unlike
/// rows of one pattern. A permutation test: the groups of both sets are dealt to the sets anew. A
/// group that both have, the same strikes in two conditions, changes sides with its other self or
/// does not; of others with the same classes as many go to each side as there were. A norm beyond
/// `max` is of patterns that differ.
/// @throws InputError  unequal numbers of classes, groups or samples, or as count_confusion
NormByChance confusion_norm_by_chance(const AnsweredSamples& first, const AnsweredSamples& second,
                                      core::RandomStream& random, std::size_t draws = 1000);

}  // namespace carillon::eval::classification
