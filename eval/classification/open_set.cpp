#include "eval/classification/open_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/classification/intervals.hpp"
#include "eval/statistics/variance.hpp"

namespace carillon::eval::classification {

namespace {

using core::nan;

std::vector<double> sorted_scores(std::span<const double> scores, const char* name) {
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (std::isnan(scores[i])) {
      throw core::InputError(fmt::format("{} score {} is no number", name, i));
    }
  }
  std::vector<double> sorted(scores.begin(), scores.end());
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

/// Variance of a mean of shares whose groups stand and fall together.
statistics::Variance clustered(const std::vector<double>& fractions, double mean,
                               std::span<const std::size_t> groups) {
  std::map<std::size_t, double> sums;
  for (std::size_t i = 0; i < fractions.size(); ++i) {
    sums[groups[i]] += (fractions[i] - mean) / static_cast<double>(fractions.size());
  }
  std::vector<double> influences;
  for (const auto& [group, sum] : sums) influences.push_back(sum);
  return statistics::variance_of_sum(influences);
}

}  // namespace

double auroc(std::span<const double> known, std::span<const double> unknown) {
  const std::vector<double> positive = sorted_scores(known, "known");
  const std::vector<double> negative = sorted_scores(unknown, "unknown");
  if (positive.empty() || negative.empty()) return nan;
  double below = 0;
  auto less = negative.begin(), equal = negative.begin();
  for (const double score : positive) {
    while (less != negative.end() && *less < score) ++less;
    while (equal != negative.end() && *equal <= score) ++equal;
    below += 0.5 * static_cast<double>((less - negative.begin()) + (equal - negative.begin()));
  }
  return below / (static_cast<double>(positive.size()) * static_cast<double>(negative.size()));
}

core::Range auroc_interval(std::span<const double> known, std::span<const std::size_t> known_groups,
                           std::span<const double> unknown,
                           std::span<const std::size_t> unknown_groups, double probability) {
  const double area = auroc(known, unknown);
  if (known.size() != known_groups.size() || unknown.size() != unknown_groups.size()) {
    throw core::InputError("scores and their groups are not as many");
  }
  const auto places = [](std::span<const double> of, std::span<const double> among) {
    const std::vector<double> sorted = sorted_scores(among, "other");
    std::vector<double> fractions;  // of `among` below each, equal ones half
    for (const double score : of) {
      const auto [first, last] = std::equal_range(sorted.begin(), sorted.end(), score);
      fractions.push_back(0.5 *
                          static_cast<double>((first - sorted.begin()) + (last - sorted.begin())) /
                          static_cast<double>(sorted.size()));
    }
    return fractions;
  };
  const statistics::Variance of_known = clustered(places(known, unknown), area, known_groups);
  const statistics::Variance of_unknown =
      clustered(places(unknown, known), 1 - area, unknown_groups);
  if (!(of_known.freedom > 0 && of_unknown.freedom > 0)) return {nan, nan};
  if (of_known.value + of_unknown.value == 0) {
    const double groups = 1 + std::min(of_known.freedom, of_unknown.freedom);
    return wilson_interval(groups * area, groups, probability);
  }
  // Of the logarithm of the area's odds, whose spread is even near the ends.
  const double slope = 1 / (area * (1 - area));
  const auto of_odds = [&](statistics::Variance one) {
    return statistics::Variance{slope * slope * one.value, one.freedom};
  };
  const core::Range odds = statistics::around(
      std::log(area / (1 - area)), {of_odds(of_known), of_odds(of_unknown)}, probability);
  return {1 / (1 + std::exp(-odds.low)), 1 / (1 + std::exp(-odds.high))};
}

double threshold_at(std::span<const double> known, double rate) {
  if (!(rate > 0 && rate <= 1)) {
    throw core::InputError(fmt::format("a true-positive rate of {}", rate), "0.95, for instance");
  }
  const std::vector<double> sorted = sorted_scores(known, "known");
  if (sorted.empty()) throw core::InputError("a threshold for no known samples");
  // A rate that is k / n but for rounding asks for k.
  const auto count = static_cast<double>(sorted.size());
  const auto wanted =
      static_cast<std::size_t>(std::clamp(std::ceil(rate * count - 1e-9 * count), 1.0, count));
  return sorted[sorted.size() - wanted];
}

double fraction_reaching(std::span<const double> scores, double threshold) {
  const std::vector<double> sorted = sorted_scores(scores, "unknown");
  if (sorted.empty()) return nan;
  const auto first = std::lower_bound(sorted.begin(), sorted.end(), threshold);
  return static_cast<double>(sorted.end() - first) / static_cast<double>(sorted.size());
}

std::vector<double> log_odds_scores(const ScoreRows& logits, double temperature) {
  check_rows(logits, "logits");
  check_temperature(temperature);
  if (logits.columns < 2) throw core::InputError("odds need two classes at least");
  std::vector<double> scores, others;
  for (std::size_t i = 0; i < logits.samples(); ++i) {
    others.assign(logits.row(i).begin(), logits.row(i).end());
    const auto greatest = std::max_element(others.begin(), others.end());
    const double best = *greatest / temperature;
    others.erase(greatest);
    for (double& z : others) z = z / temperature - best;
    scores.push_back(-log_sum_exp(others));
  }
  return scores;
}

}  // namespace carillon::eval::classification
