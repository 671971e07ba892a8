#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/numbers.hpp"
#include "core/random.hpp"
#include "eval/statistics/summary.hpp"

namespace carillon::eval::classification {

/// Interval of a fraction of independent samples (Wilson 1927): never empty, never beyond 0 and 1,
/// wide where there are few. [0, 1] for no samples. Sounds of one object are not independent: for
/// them `grouped_interval`.
/// @param right  of `samples`; need not be a whole number
/// @throws InputError  more right than samples, a negative number, or a probability not in (0, 1)
core::Range wilson_interval(double right, double samples, double probability = 0.95);

enum class AccuracyKind {
  plain,    ///< fraction of all samples that are right
  balanced  ///< mean over the classes that occur of the fraction of each that is right
};

/// What classifiers are tested on.
struct TestedSamples {
  std::span<const std::size_t> truth;   ///< class of each sample, from 0
  std::span<const std::size_t> groups;  ///< which object each sample is of; any numbers
  std::size_t classes = 0;
};

/// Interval of an accuracy for other objects of the same kind: a bootstrap that draws whole groups
/// with replacement, since samples of one object are right or wrong together. Percentiles are set
/// further apart, at those of Student's t with groups - 1 degrees of freedom, as plain ones are too
/// narrow of few groups (Hesterberg 2015, section 4.4).
///
/// Where all draws are alike (all is right; one group) they say nothing: the interval is then
/// Wilson's, as of one sample for each group. Balanced: a class with one object alone is missing
/// from a third of the draws, whose mean is over the others; its own spread is not known, and the
/// interval is too narrow by it.
/// @param random  decides the draws
/// @throws InputError  spans of unequal length, no samples, or a class that there is not
core::Range grouped_interval(const TestedSamples& tested, std::span<const std::size_t> predicted,
                             AccuracyKind kind, core::RandomStream& random,
                             double probability = 0.95, int draws = 2000);

/// An accuracy over classifiers that differ by the seed of their training alone, all tested on the
/// same samples.
struct SeedsSummary {
  double mean = 0;
  double deviation = 0;  ///< standard deviation between seeds; NaN for one
  /// What other seeds come to on other objects. Seeds and objects are crossed, not nested, and
  /// seeds are few, of which a bootstrap is too narrow: the variances of the mean over seeds and
  /// over objects (linearised, Cochran 1977, section 6.3, with groups as units) are added, with
  /// degrees of freedom after Satterthwaite (1946). Adding counts their interaction twice: never
  /// too narrow by it. NaN for one seed or one group; where nothing varies, Wilson's of the groups.
  core::Range seeds_and_groups;
};

/// @param predicted  for each seed, the class that each sample was taken for
/// @throws InputError  no seeds, or as grouped_interval
SeedsSummary interval_over_seeds(const TestedSamples& tested,
                                 std::span<const std::vector<std::size_t>> predicted,
                                 AccuracyKind kind, double probability = 0.95);

/// How much more of the samples classifiers of one kind have right than those of another, all
/// tested on the same samples: much surer than two accuracies' intervals tell, as both find the
/// same samples hard.
struct AccuracyDifference {
  double mean = 0;
  /// What other objects, and of several seeds other seeds of both, come to: variances as in
  /// SeedsSummary, of the groups' differences. NaN for one group, or where nothing varies.
  core::Range bounds;
};

/// @param first, second  for each seed, the class that each sample was taken for
/// @throws InputError  no seeds of one, or as grouped_interval
AccuracyDifference accuracy_difference(const TestedSamples& tested,
                                       std::span<const std::vector<std::size_t>> first,
                                       std::span<const std::vector<std::size_t>> second,
                                       AccuracyKind kind = AccuracyKind::plain,
                                       double probability = 0.95);

}  // namespace carillon::eval::classification
