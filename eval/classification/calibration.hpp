#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "eval/classification/score_rows.hpp"

namespace carillon::eval {

/// Mean of -log p(true class) over samples [nat], p = softmax(z / T); finite for finite logits.
/// NaN for no samples.
/// @throws InputError  as check_rows and check_classes, or a temperature that is not positive
double negative_log_likelihood(const ScoreRows& logits, std::span<const std::size_t> truth,
                               double temperature = 1);

/// What divides a network's logits so that its probabilities are right as often as they say.
struct FittedTemperature {
  double value = 1;
  double before = 0;  ///< negative log-likelihood at 1 [nat]
  double after = 0;   ///< at `value`
  /// There is no inner minimum: with every sample right by a margin the likelihood has its limit
  /// at T -> 0, with logits no better than chance at T -> infinity. `value` is then the end of the
  /// range that is sought, 1e-3 and 1e3 times the logits' mean range (greatest less least); 1 where
  /// all logits of each row are equal.
  bool at_end = false;
};

/// Temperature scaling (Guo et al. 2017, section 4.2): minimises the negative log-likelihood of
/// validation samples, which is convex in 1 / T. It changes no prediction.
/// @throws InputError  no samples, or as negative_log_likelihood
FittedTemperature fit_temperature(const ScoreRows& logits, std::span<const std::size_t> truth);

/// Samples whose predicted class has a probability in (low, high]; the first bin has 0 too.
struct ReliabilityBin {
  double low = 0;
  double high = 0;
  std::size_t samples = 0;
  double confidence = 0;  ///< mean probability of the predicted class; NaN in an empty bin
  double accuracy = 0;    ///< share that is right; NaN in an empty bin
};

/// Reliability diagram in bins of equal width (Guo et al. 2017, section 2).
/// @param probabilities  rows that sum to 1, e.g. of `softmax`
/// @throws InputError  no bins, a row that is no distribution (names it), or as check_classes
std::vector<ReliabilityBin> reliability(const ScoreRows& probabilities,
                                        std::span<const std::size_t> truth, std::size_t bins = 15);

/// Expected calibration error: mean of |accuracy - confidence| over bins, weighted by their samples
/// (Guo et al. 2017, eq. 3). By chance it is positive even for probabilities that are right: on
/// average at most 0.4 sqrt(bins / samples). NaN for no samples.
double expected_calibration_error(std::span<const ReliabilityBin> bins);

/// Mean of sum_c (p_c - y_c)^2 over samples, y the true class's unit vector (Brier 1950): 0 to 2.
/// NaN for no samples.
/// @throws InputError  as reliability
double brier_score(const ScoreRows& probabilities, std::span<const std::size_t> truth);

}  // namespace carillon::eval
