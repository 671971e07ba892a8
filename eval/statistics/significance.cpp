#include "eval/statistics/significance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/statistics/summary.hpp"

namespace carillon::eval::statistics {

namespace {

void check_finite(std::span<const double> values) {
  for (const double value : values) {
    if (!std::isfinite(value)) {
      throw core::InputError(fmt::format("{} among the values of a test of significance", value),
                             "leave out what could not be measured");
    }
  }
}

/// Two-sided probability of a sum of ranks at most this small: the number of subsets of 1 ... n
/// with each sum, over 2^n.
double exact_probability(double smaller_sum, std::size_t n) {
  std::vector<double> subsets(n * (n + 1) / 2 + 1, 0.0);
  subsets[0] = 1;
  for (std::size_t rank = 1; rank <= n; ++rank) {
    for (std::size_t sum = subsets.size() - 1; sum >= rank; --sum) {
      subsets[sum] += subsets[sum - rank];
    }
  }
  const auto last = static_cast<std::ptrdiff_t>(smaller_sum);
  const double below = std::accumulate(subsets.begin(), subsets.begin() + last + 1, 0.0);
  return std::min(1.0, 2 * std::ldexp(below, -static_cast<int>(n)));
}

struct Difference {
  double size = 0;
  bool positive = false;
};

}  // namespace

SignedRank signed_rank_test(std::span<const double> a, std::span<const double> b) {
  if (a.size() != b.size()) {
    throw core::InputError(
        fmt::format("{} and {} values are not pairs for the signed-rank test", a.size(), b.size()));
  }
  check_finite(a);
  check_finite(b);
  std::vector<Difference> differences;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] != b[i]) differences.push_back({std::abs(a[i] - b[i]), a[i] > b[i]});
  }
  std::sort(differences.begin(), differences.end(),
            [](const Difference& x, const Difference& y) { return x.size < y.size; });
  SignedRank test;
  test.pairs = differences.size();
  if (differences.empty()) return test;
  double ties = 0;  // sum of t^3 - t over groups of t equal differences
  for (std::size_t first = 0; first < differences.size();) {
    std::size_t end = first + 1;
    while (end < differences.size() && differences[end].size == differences[first].size) ++end;
    const double rank = 0.5 * static_cast<double>(first + 1 + end);
    const double count = static_cast<double>(end - first);
    ties += count * (count * count - 1);
    for (; first < end; ++first) {
      (differences[first].positive ? test.positive : test.negative) += rank;
    }
  }
  constexpr std::size_t max_exact = 50;
  const double smaller = std::min(test.positive, test.negative);
  const double n = static_cast<double>(test.pairs);
  if (test.pairs == a.size() && test.pairs <= max_exact && ties == 0) {
    test.p = exact_probability(smaller, test.pairs);
    return test;
  }
  const double expected = n * (n + 1) / 4;
  const double variance = n * (n + 1) * (2 * n + 1) / 24 - ties / 48;
  const double z = (smaller - expected) / std::sqrt(variance);
  test.p = std::min(1.0, 2 * boost::math::cdf(boost::math::normal(), z));
  return test;
}

WelchTest welch_test(std::span<const double> a, std::span<const double> b) {
  check_finite(a);
  check_finite(b);
  WelchTest test;
  const auto variance_of_mean = [](std::span<const double> values) {
    const double centre = mean(values), n = static_cast<double>(values.size());
    double sum = 0;
    for (const double value : values) sum += (value - centre) * (value - centre);
    return sum / (n - 1) / n;
  };
  if (a.size() < 2 || b.size() < 2) return {core::nan, core::nan, core::nan};
  const double va = variance_of_mean(a), vb = variance_of_mean(b);
  if (!(va + vb > 0)) return {core::nan, core::nan, core::nan};
  test.t = (mean(a) - mean(b)) / std::sqrt(va + vb);
  test.freedom =
      (va + vb) * (va + vb) /
      (va * va / static_cast<double>(a.size() - 1) + vb * vb / static_cast<double>(b.size() - 1));
  test.p = 2 * boost::math::cdf(boost::math::students_t(test.freedom), -std::abs(test.t));
  return test;
}

std::vector<double> holm(std::span<const double> probabilities) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < probabilities.size(); ++i) {
    if (!std::isnan(probabilities[i])) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
    return probabilities[x] < probabilities[y];
  });
  std::vector<double> raised(probabilities.begin(), probabilities.end());
  double minimum = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double factor = static_cast<double>(order.size() - k);
    minimum = std::max(minimum, std::min(1.0, factor * probabilities[order[k]]));
    raised[order[k]] = minimum;
  }
  return raised;
}

}  // namespace carillon::eval::statistics
