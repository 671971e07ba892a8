#include "eval/classification/novelty.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace carillon::eval {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Auroc, IsSciPys) {
  // scipy.stats.mannwhitneyu(known, novel).statistic / 20
  const std::vector<double> known = {0.9, 0.8, 0.8, 0.4, 0.35}, novel = {0.8, 0.5, 0.4, 0.1};
  EXPECT_NEAR(auroc(known, novel), 0.675, 1e-15);
}

TEST(Auroc, HasStatedEnds) {
  const std::vector<double> low = {-infinity, 1, 2}, high = {3, 4, infinity};
  EXPECT_EQ(auroc(high, low), 1);
  EXPECT_EQ(auroc(low, high), 0);
  EXPECT_EQ(auroc(std::vector<double>(5, 2), std::vector<double>(3, 2)), 0.5);
  EXPECT_TRUE(std::isnan(auroc({}, low)));
  EXPECT_TRUE(std::isnan(auroc(low, {})));
  try {
    auroc(low, std::vector{1.0, std::nan("")});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_EQ(error.message(), "novel score 1 is no number");
  }
}

std::vector<double> any_scores() {
  std::vector<double> scores;
  for (const int one :
       *rc::gen::nonEmpty(rc::gen::container<std::vector<int>>(rc::gen::inRange(-20, 20)))) {
    scores.push_back(0.25 * one);
  }
  return scores;
}

TEST(Auroc, IsTheShareOfPairsAndHeedsOrderAlone) {
  EXPECT_TRUE(rc::check("pairs, monotone maps, exchange", [] {
    const auto known = any_scores(), novel = any_scores();
    double pairs = 0;
    for (const double a : known) {
      for (const double b : novel) pairs += a > b ? 1 : (a == b ? 0.5 : 0);
    }
    const double area = auroc(known, novel);
    RC_ASSERT(std::abs(area - pairs / static_cast<double>(known.size() * novel.size())) < 1e-12);
    const auto mapped = [](std::vector<double> scores) {
      for (double& one : scores) one = std::exp(one) + one * one * one;
      return scores;
    };
    RC_ASSERT(auroc(mapped(known), mapped(novel)) == area);
    RC_ASSERT(std::abs(auroc(novel, known) - (1 - area)) < 1e-12);
  }));
}

TEST(ThresholdAt, IsReachedByTheShareAskedFor) {
  std::vector<double> known;
  for (int i = 1; i <= 20; ++i) known.push_back(i);
  EXPECT_EQ(threshold_at(known, 0.95), 2);
  EXPECT_EQ(threshold_at(known, 1), 1);
  EXPECT_EQ(threshold_at(known, 0.15), 18);
  EXPECT_EQ(threshold_at(known, 1e-9), 20);
  EXPECT_EQ(share_reaching(std::vector<double>{1, 2, 3, 0}, 2), 0.5);
  EXPECT_TRUE(std::isnan(share_reaching({}, 2)));
  EXPECT_THROW(threshold_at({}, 0.95), core::InputError);
  EXPECT_THROW(threshold_at(known, 0), core::InputError);
  EXPECT_THROW(threshold_at(known, 1.01), core::InputError);
  EXPECT_TRUE(rc::check("the greatest such threshold", [] {
    const auto scores = any_scores();
    const double rate = *rc::gen::inRange(1, 101) / 100.0;
    const double threshold = threshold_at(scores, rate);
    RC_ASSERT(share_reaching(scores, threshold) >= rate - 1e-9);
    RC_ASSERT(share_reaching(scores, std::nextafter(threshold, infinity)) < rate);
  }));
}

TEST(LogOdds, AreThoseOfTheProbabilities) {
  // p = scipy.special.softmax(z / T, axis=1).max(1); numpy.log(p / (1 - p))
  const std::vector<double> z = {2, 1, 0, 0.5, 2.5, -1}, shifted = {7, 6, 5};
  EXPECT_NEAR(log_odds_scores({z, 3})[0], 0.68673831, 1e-8);
  EXPECT_NEAR(log_odds_scores({z, 3})[1], 1.79858672, 1e-8);
  EXPECT_NEAR(log_odds_scores({z, 3}, 2)[0], 0.02592302, 1e-8);
  EXPECT_NEAR(log_odds_scores({shifted, 3})[0], 0.68673831, 1e-8);
  // Where probabilities are 1 there is still an order.
  const std::vector<double> sure = {80, 0, 90, 0};
  EXPECT_EQ(log_odds_scores({sure, 2}), (std::vector<double>{80, 90}));
  EXPECT_THROW(log_odds_scores({std::vector{infinity, 0.0}, 2}), core::InputError);
  EXPECT_THROW(log_odds_scores({z, 3}, 0), core::InputError);
  EXPECT_THROW(log_odds_scores({z, 1}), core::InputError);
}

}  // namespace
}  // namespace carillon::eval
