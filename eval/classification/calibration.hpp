#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/random.hpp"
#include "eval/classification/score_rows.hpp"

namespace carillon::eval::classification {

/// What divides a network's logits so that its probabilities are right as often as they say
/// (temperature scaling, Guo et al. 2017, section 4.2): minimises the mean cross-entropy of
/// validation samples, which is convex in 1 / T. It changes no prediction.
///
/// n samples that are all right leave a doubt of 1 / (n + 2) (Platt 1999, section 2.2): so much of
/// each row's target falls to its other classes, alike. Without it few samples that are all right
/// would make every confidence 1.
/// @return within 1e-3 and 1e3 times the logits' mean range (greatest less least); the latter where
///         they are no better than chance; 1 where all logits of each row are equal
/// @throws InputError  no samples, or as check_rows and check_classes
double fit_temperature(const ScoreRows& logits, std::span<const std::size_t> truth);

/// Samples whose predicted class has a probability in (low, high]; the first bin has 0 too.
struct ReliabilityBin {
  double low = 0;
  double high = 0;
  std::size_t samples = 0;
  double confidence = 0;  ///< mean probability of the predicted class; NaN in an empty bin
  double accuracy = 0;    ///< share that is right; NaN in an empty bin
};

inline constexpr std::size_t usual_bins = 15;

/// Reliability diagram in bins of equal width (Guo et al. 2017, section 2).
/// @param probabilities  rows that sum to 1, e.g. of `softmax`
/// @throws InputError  no bins, a row that is no distribution (names it), or as check_classes
std::vector<ReliabilityBin> reliability(const ScoreRows& probabilities,
                                        std::span<const std::size_t> truth,
                                        std::size_t bins = usual_bins);

/// Expected calibration error: mean of |accuracy - confidence| over bins, weighted by their samples
/// (Guo et al. 2017, eq. 3). By chance it is positive even for probabilities that are right: on
/// average at most 0.4 sqrt(bins / samples). NaN for no samples.
double expected_calibration_error(std::span<const ReliabilityBin> bins);

/// What that error, of `usual_bins`, is on average where probabilities are right, if the samples of
/// a group stand and fall together: mean over draws of which are right. An error near it shows
/// nothing. Samples that are groups of their own make the least of it. NaN for no samples.
/// @param groups  of each sample; any numbers
/// @throws InputError  spans of unequal length
double calibration_error_by_chance(const ScoreRows& probabilities,
                                   std::span<const std::size_t> groups, core::RandomStream& random,
                                   int draws = 100);

}  // namespace carillon::eval::classification
