#include "eval/classification/intervals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/classification/score_rows.hpp"
#include "eval/statistics/variance.hpp"

namespace carillon::eval::classification {

namespace {

using core::nan;

/// Samples, and those that are right, of every group and class: groups x classes.
struct GroupCounts {
  std::size_t groups = 0;
  std::size_t classes = 0;
  std::vector<double> right;
  std::vector<double> samples;
};

GroupCounts count_groups(const TestedSamples& tested, std::span<const std::size_t> predicted) {
  check_classes(tested.truth, predicted.size(), tested.classes);
  check_classes(predicted, tested.truth.size(), tested.classes);
  if (tested.groups.size() != tested.truth.size()) {
    throw core::InputError(
        fmt::format("{} groups of {} samples", tested.groups.size(), tested.truth.size()));
  }
  if (tested.truth.empty()) throw core::InputError("an accuracy of no samples has no interval");
  std::vector<std::size_t> names(tested.groups.begin(), tested.groups.end());
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  GroupCounts counts{names.size(), tested.classes, {}, {}};
  counts.right.assign(counts.groups * counts.classes, 0);
  counts.samples = counts.right;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    const auto group = static_cast<std::size_t>(
        std::lower_bound(names.begin(), names.end(), tested.groups[i]) - names.begin());
    const std::size_t at = group * counts.classes + tested.truth[i];
    counts.samples[at] += 1;
    counts.right[at] += predicted[i] == tested.truth[i] ? 1 : 0;
  }
  return counts;
}

/// Right ones and samples, summed to what an accuracy is the mean ratio of: each class, or all.
struct Ratios {
  std::vector<double> right;
  std::vector<double> samples;

  Ratios(std::size_t classes, AccuracyKind kind)
      : right(kind == AccuracyKind::plain ? 1 : classes), samples(right.size()) {}

  void add(const GroupCounts& counts, std::size_t group) {
    for (std::size_t c = 0; c < counts.classes; ++c) {
      const std::size_t to = right.size() == 1 ? 0 : c;
      right[to] += counts.right[group * counts.classes + c];
      samples[to] += counts.samples[group * counts.classes + c];
    }
  }

  double occurring() const {
    return static_cast<double>(
        std::count_if(samples.begin(), samples.end(), [](double number) { return number > 0; }));
  }

  double mean() const {
    double sum = 0;
    for (std::size_t c = 0; c < right.size(); ++c)
      sum += samples[c] > 0 ? right[c] / samples[c] : 0;
    return sum / occurring();
  }
};

Ratios all_groups(const GroupCounts& counts, AccuracyKind kind) {
  Ratios ratios(counts.classes, kind);
  for (std::size_t g = 0; g < counts.groups; ++g) ratios.add(counts, g);
  return ratios;
}

/// What each group adds to the accuracy's deviation, to first order; adds it to `influences`.
void add_influences(const GroupCounts& counts, AccuracyKind kind, std::vector<double>& influences) {
  const Ratios all = all_groups(counts, kind);
  for (std::size_t g = 0; g < counts.groups; ++g) {
    Ratios one(counts.classes, kind);
    one.add(counts, g);
    for (std::size_t c = 0; c < all.right.size(); ++c) {
      if (all.samples[c] == 0) continue;
      const double ratio = all.right[c] / all.samples[c];
      influences[g] += (one.right[c] - ratio * one.samples[c]) / (all.samples[c] * all.occurring());
    }
  }
}

/// An accuracy over seeds, and what it varies by.
struct Spread {
  double mean = 0;
  statistics::Variance of_seeds;   ///< 0 of one seed
  std::vector<double> influences;  ///< of each group on the mean, to first order
};

Spread spread_of(const TestedSamples& tested, std::span<const std::vector<std::size_t>> predicted,
                 AccuracyKind kind) {
  if (predicted.empty()) throw core::InputError("an accuracy over no seeds");
  Spread spread;
  std::vector<double> accuracies;
  for (const std::vector<std::size_t>& one : predicted) {
    const GroupCounts counts = count_groups(tested, one);
    spread.influences.resize(counts.groups);
    accuracies.push_back(all_groups(counts, kind).mean());
    add_influences(counts, kind, spread.influences);
  }
  const auto seeds = static_cast<double>(accuracies.size());
  for (double& influence : spread.influences) influence /= seeds;
  spread.mean = statistics::mean(accuracies);
  if (accuracies.size() < 2) return spread;
  double squares = 0;
  for (const double one : accuracies) squares += (one - spread.mean) * (one - spread.mean);
  spread.of_seeds = {squares / (seeds - 1) / seeds, seeds - 1};
  return spread;
}

void check_probability(double probability) {
  if (!(probability > 0 && probability < 1)) {
    throw core::InputError(fmt::format("an interval of probability {}", probability),
                           "0.95, for instance");
  }
}

/// Hesterberg's probability, whose percentiles are as wide as Student's t.
double expanded(double probability, double groups) {
  const double widest =
      std::sqrt(groups / (groups - 1)) * statistics::students_t(probability, groups - 1);
  return 1 - 2 * boost::math::cdf(boost::math::normal(), -widest);
}

}  // namespace

core::Range wilson_interval(double right, double samples, double probability) {
  check_probability(probability);
  if (!(right >= 0 && right <= samples) || !std::isfinite(samples)) {
    throw core::InputError(fmt::format("{} of {} samples are no fraction", right, samples));
  }
  if (samples == 0) return {0, 1};
  const double z = boost::math::quantile(boost::math::normal(), 0.5 + 0.5 * probability);
  const double fraction = right / samples, square = z * z / samples;
  const double middle = (fraction + square / 2) / (1 + square);
  const double half =
      z * std::sqrt(fraction * (1 - fraction) / samples + square / (4 * samples)) / (1 + square);
  // Rounding must not cut off what was seen.
  return {std::clamp(middle - half, 0.0, fraction), std::clamp(middle + half, fraction, 1.0)};
}

core::Range grouped_interval(const TestedSamples& tested, std::span<const std::size_t> predicted,
                             AccuracyKind kind, core::RandomStream& random, double probability,
                             int draws) {
  check_probability(probability);
  const GroupCounts counts = count_groups(tested, predicted);
  const auto groups = static_cast<double>(counts.groups);
  core::Range bounds;
  if (counts.groups > 1) {
    std::vector<double> places(counts.groups);
    std::iota(places.begin(), places.end(), 0);
    const auto statistic = [&](std::span<const double> drawn) {
      Ratios ratios(counts.classes, kind);
      for (const double place : drawn) ratios.add(counts, static_cast<std::size_t>(place));
      return ratios.mean();
    };
    bounds = statistics::bootstrap(places, statistic, random, expanded(probability, groups), draws);
  }
  if (bounds.low < bounds.high) return bounds;
  return wilson_interval(groups * all_groups(counts, kind).mean(), groups, probability);
}

SeedsSummary interval_over_seeds(const TestedSamples& tested,
                                 std::span<const std::vector<std::size_t>> predicted,
                                 AccuracyKind kind, double probability) {
  check_probability(probability);
  const Spread spread = spread_of(tested, predicted, kind);
  SeedsSummary summary{spread.mean, nan, {nan, nan}};
  const auto seeds = static_cast<double>(predicted.size());
  const auto groups = static_cast<double>(spread.influences.size());
  if (predicted.size() < 2) return summary;
  summary.deviation = std::sqrt(spread.of_seeds.value * seeds);
  const auto within = [](const core::Range& bounds) {
    return core::Range{std::max(0.0, bounds.low), std::min(1.0, bounds.high)};
  };
  if (groups < 2) return summary;
  const statistics::Variance of_groups = statistics::variance_of_sum(spread.influences);
  summary.seeds_and_groups =
      spread.of_seeds.value + of_groups.value > 0
          ? within(statistics::around(spread.mean, {spread.of_seeds, of_groups}, probability))
          : wilson_interval(groups * spread.mean, groups, probability);
  return summary;
}

AccuracyDifference accuracy_difference(const TestedSamples& tested,
                                       std::span<const std::vector<std::size_t>> first,
                                       std::span<const std::vector<std::size_t>> second,
                                       AccuracyKind kind, double probability) {
  check_probability(probability);
  const Spread one = spread_of(tested, first, kind);
  const Spread other = spread_of(tested, second, kind);
  AccuracyDifference difference{one.mean - other.mean, {nan, nan}};
  if (one.influences.size() < 2) return difference;
  std::vector<double> influences = one.influences;
  for (std::size_t g = 0; g < influences.size(); ++g) influences[g] -= other.influences[g];
  const statistics::Variance of_groups = statistics::variance_of_sum(influences);
  if (one.of_seeds.value + other.of_seeds.value + of_groups.value > 0) {
    difference.bounds =
        statistics::around(difference.mean, {one.of_seeds, other.of_seeds, of_groups}, probability);
  }
  return difference;
}

}  // namespace carillon::eval::classification
