#include "eval/classification/novelty.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace carillon::eval {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

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

}  // namespace

double auroc(std::span<const double> known, std::span<const double> novel) {
  const std::vector<double> positive = sorted_scores(known, "known");
  const std::vector<double> negative = sorted_scores(novel, "novel");
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

double share_reaching(std::span<const double> scores, double threshold) {
  const std::vector<double> sorted = sorted_scores(scores, "novel");
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

}  // namespace carillon::eval
