#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/numbers.hpp"
#include "eval/classification/score_rows.hpp"
#include "eval/statistics/summary.hpp"

// Whether a sample is of none of the classes. Scores tell how familiar it is: the greater, the more
// like what was trained on.

namespace carillon::eval::classification {

/// Area under the receiver operating characteristic: the probability that a known sample's score is
/// above a unknown one's, equal ones counted half (Mann and Whitney 1947). 0.5: the score tells
/// nothing. Infinite scores are the greatest and the least. NaN where either is empty.
/// @throws InputError  a score that is NaN; names its place
double auroc(std::span<const double> known, std::span<const double> unknown);

/// Interval of `auroc` for other objects of the same kinds: each sample's fraction of the area,
/// summed over the groups that stand and fall together (Obuchowski 1997; of single samples DeLong,
/// DeLong and Clarke-Pearson 1988), with Student's t of the odds' logarithm (Pepe 2003). Where
/// nothing varies, Wilson's of the fewer groups. Within 0 and 1; NaN where either has but one
/// group.
/// @param known_groups, unknown_groups  of each score; any numbers, not compared with each other
/// @throws InputError  as auroc, or groups of another length
core::Range auroc_interval(std::span<const double> known, std::span<const std::size_t> known_groups,
                           std::span<const double> unknown,
                           std::span<const std::size_t> unknown_groups, double probability = 0.95);

/// The greatest threshold that at least this fraction of known samples reaches (score >=
/// threshold).
/// @param rate  true-positive rate, in (0, 1]
/// @throws InputError  no samples, a rate out of range, or a score that is NaN
double threshold_at(std::span<const double> known, double rate);

/// Share of scores that reach a threshold: of unknown samples, how many are taken for known. NaN
/// for none.
/// @throws InputError  a score that is NaN
double fraction_reaching(std::span<const double> scores, double threshold);

/// Logarithm of the odds of each row's predicted class. It orders as its probability does
/// (Hendrycks and Gimpel 2017), and does not run into 1.
/// @throws InputError  as softmax, or a single column
std::vector<double> log_odds_scores(const ScoreRows& logits, double temperature = 1);

}  // namespace carillon::eval::classification
