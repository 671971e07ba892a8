#include "eval/statistics/summary.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/numbers.hpp"

namespace carillon::eval::statistics {

namespace {

using core::nan;

double quantile_of_sorted(const std::vector<double>& sorted, double share) {
  const double place = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(place));
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

}  // namespace

double quantile(std::span<const double> values, double share) {
  if (values.empty()) return nan;
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  return quantile_of_sorted(sorted, share);
}

double mean(std::span<const double> values) {
  if (values.empty()) return nan;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

Bounds bootstrap(std::span<const double> values, const Statistic& statistic,
                 core::RandomStream& random, double probability, int draws) {
  if (values.empty()) return {nan, nan};
  std::vector<double> sample(values.size()), statistics;
  for (int draw = 0; draw < draws; ++draw) {
    for (double& value : sample) value = values[random.index(values.size())];
    statistics.push_back(statistic(sample));
  }
  std::sort(statistics.begin(), statistics.end());
  return {quantile_of_sorted(statistics, (1 - probability) / 2),
          quantile_of_sorted(statistics, (1 + probability) / 2)};
}

}  // namespace carillon::eval::statistics
