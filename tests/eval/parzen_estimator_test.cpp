// Where a search by trial goes next.
#include "eval/statistics/parzen_estimator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace carillon::eval {
namespace {

using statistics::ParzenAxis;
using statistics::ParzenPoint;

/// Best loss of a search of 40 trials; drawn anywhere where it does not learn.
template <class Loss>
double searched(const std::vector<ParzenAxis>& axes, std::uint64_t seed, bool learns,
                const Loss& loss) {
  core::RandomStream random(seed, 0, "search");
  std::vector<ParzenPoint> best_first;
  for (int trial = 0; trial < 40; ++trial) {
    const auto known =
        std::span<const ParzenPoint>(best_first).first(learns ? best_first.size() : 0);
    const ParzenPoint point = statistics::next_parzen_point(axes, known, random).value();
    const auto worse =
        std::find_if(best_first.begin(), best_first.end(),
                     [&](const ParzenPoint& one) { return loss(one) > loss(point); });
    best_first.insert(worse, point);
  }
  return loss(best_first.front());
}

template <class Loss>
double median_of_seeds(const std::vector<ParzenAxis>& axes, bool learns, const Loss& loss) {
  std::vector<double> found;
  for (std::uint64_t seed = 0; seed < 41; ++seed) {
    found.push_back(searched(axes, seed, learns, loss));
  }
  std::nth_element(found.begin(), found.begin() + 20, found.end());
  return found[20];
}

TEST(ParzenEstimator, FindsAMinimumOfNumbersAndChoicesSoonerThanDrawsDo) {
  const std::vector<ParzenAxis> axes = {{}, {}, {.choices = 5}};
  const auto loss = [](const ParzenPoint& at) {
    return std::pow(at[0] - 0.3, 2) + std::pow(at[1] - 0.9, 2) + (at[2] == 3 ? 0 : 0.1);
  };
  const double learnt = median_of_seeds(axes, true, loss);
  EXPECT_LT(learnt, median_of_seeds(axes, false, loss) / 3);
  EXPECT_LT(learnt, 0.01);
}

TEST(ParzenEstimator, TriesEveryChoiceOnceAndThenNone) {
  const std::vector<ParzenAxis> axes = {{.choices = 3}, {.choices = 5}};
  core::RandomStream random(1, 0, "search");
  std::vector<ParzenPoint> tried;
  while (const auto point = statistics::next_parzen_point(axes, tried, random)) {
    ASSERT_LT(tried.size(), 15U);
    EXPECT_TRUE((*point)[0] < 3 && (*point)[1] < 5);
    tried.push_back(*point);
  }
  EXPECT_EQ(std::set<ParzenPoint>(tried.begin(), tried.end()).size(), 15U);
}

TEST(ParzenEstimator, TakesTheChoiceOfTheGoodOnes) {
  // The best two of ten took choice 1: l is (2 + 1) / 4 of it and g, of the other eight, which took
  // 0, (0 + 1) / 10. Of 24 draws some are of choice 1, and all these are better than the others.
  const std::vector<ParzenAxis> axes = {{.choices = 2}, {}};
  std::vector<ParzenPoint> best_first;
  for (int i = 0; i < 10; ++i) best_first.push_back({i < 2 ? 1.0 : 0.0, 0.1 * i});
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    core::RandomStream random(seed, 0, "search");
    const auto point = statistics::next_parzen_point(axes, best_first, random).value();
    EXPECT_EQ(point[0], 1) << seed;
    EXPECT_TRUE(point[1] >= 0 && point[1] <= 1);
  }
}

}  // namespace
}  // namespace carillon::eval
