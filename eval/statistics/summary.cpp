#include "eval/statistics/summary.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace carillon::eval::statistics {

using core::nan;

double mean(std::span<const double> values) {
  if (values.empty()) return nan;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

core::Range bootstrap(std::span<const double> values, const Statistic& statistic,
                      core::RandomStream& random, double probability, int draws) {
  if (values.empty()) return {nan, nan};
  std::vector<double> sample(values.size()), statistics;
  for (int draw = 0; draw < draws; ++draw) {
    for (double& value : sample) value = values[random.index(values.size())];
    statistics.push_back(statistic(sample));
  }
  std::sort(statistics.begin(), statistics.end());
  return {core::quantile_of_sorted(statistics, (1 - probability) / 2),
          core::quantile_of_sorted(statistics, (1 + probability) / 2)};
}

}  // namespace carillon::eval::statistics
