#include "eval/classification/open_set.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "core/random.hpp"
#include "eval/classification/intervals.hpp"
#include "eval/statistics/variance.hpp"

namespace carillon::eval {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Auroc, IsSciPys) {
  // scipy.stats.mannwhitneyu(known, unknown).statistic / 20
  const std::vector<double> known = {0.9, 0.8, 0.8, 0.4, 0.35}, unknown = {0.8, 0.5, 0.4, 0.1};
  EXPECT_NEAR(classification::auroc(known, unknown), 0.675, 1e-15);
}

TEST(Auroc, HasStatedEnds) {
  const std::vector<double> low = {-infinity, 1, 2}, high = {3, 4, infinity};
  EXPECT_EQ(classification::auroc(high, low), 1);
  EXPECT_EQ(classification::auroc(low, high), 0);
  EXPECT_EQ(classification::auroc(std::vector<double>(5, 2), std::vector<double>(3, 2)), 0.5);
  EXPECT_TRUE(std::isnan(classification::auroc({}, low)));
  EXPECT_TRUE(std::isnan(classification::auroc(low, {})));
  try {
    classification::auroc(low, std::vector{1.0, std::nan("")});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_EQ(error.message(), "unknown score 1 is no number");
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
    const auto known = any_scores(), unknown = any_scores();
    double pairs = 0;
    for (const double a : known) {
      for (const double b : unknown) pairs += a > b ? 1 : (a == b ? 0.5 : 0);
    }
    const double area = classification::auroc(known, unknown);
    RC_ASSERT(std::abs(area - pairs / static_cast<double>(known.size() * unknown.size())) < 1e-12);
    const auto mapped = [](std::vector<double> scores) {
      for (double& one : scores) one = std::exp(one) + one * one * one;
      return scores;
    };
    RC_ASSERT(classification::auroc(mapped(known), mapped(unknown)) == area);
    RC_ASSERT(std::abs(classification::auroc(unknown, known) - (1 - area)) < 1e-12);
  }));
}

/// Scores about a mean, in groups whose members are alike.
struct Groups {
  std::vector<double> scores;
  std::vector<std::size_t> groups;

  Groups(std::size_t count, std::size_t each, double mean, core::RandomStream& random) {
    for (std::size_t g = 0; g < count; ++g) {
      const double own = mean + random.normal();
      for (std::size_t i = 0; i < each; ++i) {
        scores.push_back(own + 0.5 * random.normal());
        groups.push_back(7 * g);
      }
    }
  }
};

TEST(AurocInterval, HoldsTheTruthOfOtherBodies) {
  // Both have a variance of 1.25: known above unknown with the probability of a normal one below
  // 1.5 / sqrt(2.5).
  const double truth = 0.5 * std::erfc(-1.5 / std::sqrt(2.5) / std::sqrt(2.0));
  int held = 0, held_by_singles = 0;
  constexpr int repetitions = 400;
  for (int r = 0; r < repetitions; ++r) {
    core::RandomStream random(3, static_cast<std::uint64_t>(r), "test.auroc");
    const Groups known(14, 12, 1.5, random), unknown(10, 12, 0, random);
    const auto holds = [&](core::Range bounds) {
      return bounds.low <= truth && truth <= bounds.high;
    };
    held += holds(
        classification::auroc_interval(known.scores, known.groups, unknown.scores, unknown.groups));
    std::vector<std::size_t> singles(known.scores.size());
    std::iota(singles.begin(), singles.end(), std::size_t{0});
    held_by_singles += holds(classification::auroc_interval(
        known.scores, singles, unknown.scores, std::span(singles).first(unknown.scores.size())));
  }
  EXPECT_GT(held, 0.9 * repetitions);
  EXPECT_LT(held, 0.995 * repetitions);
  EXPECT_LT(held_by_singles, 0.7 * repetitions);
}

TEST(AurocInterval, IsDeLongsOfSingleSamples) {
  // Structural components by hand: known 0.75, 1, 1 of two unknown ones; unknown 5/6, 1 of three.
  const std::vector<double> known = {1, 3, 4}, unknown = {1, 0};
  const core::Range bounds = classification::auroc_interval(
      known, std::vector<std::size_t>{0, 1, 2}, unknown, std::vector<std::size_t>{0, 1});
  const double area = 11.0 / 12;
  const double of_known = (std::pow(0.75 - area, 2) + 2 * std::pow(1 - area, 2)) / 2 / 3;
  const double of_unknown = (std::pow(5.0 / 6 - area, 2) + std::pow(1 - area, 2)) / 1 / 2;
  const double sum = of_known + of_unknown;
  const double freedom = sum * sum / (of_known * of_known / 2 + of_unknown * of_unknown / 1);
  const double half = statistics::students_t(0.95, freedom) * std::sqrt(sum) / (area * (1 - area));
  EXPECT_NEAR(bounds.low, 1 / (1 + std::exp(half) / 11), 1e-12);  // odds of 11
  EXPECT_NEAR(bounds.high, 1 / (1 + std::exp(-half) / 11), 1e-12);
}

TEST(AurocInterval, SaysWhatCannotBeKnown) {
  const std::vector<double> low = {0, 1}, high = {2, 3};
  const std::vector<std::size_t> one = {0, 0}, two = {0, 1};
  EXPECT_TRUE(std::isnan(classification::auroc_interval(high, two, low, one).low));
  EXPECT_EQ(classification::auroc_interval(high, two, low, two).low,
            classification::wilson_interval(2, 2).low);
  EXPECT_EQ(classification::auroc_interval(high, two, low, two).high, 1);
  EXPECT_THROW(classification::auroc_interval(high, std::vector<std::size_t>{0}, low, two),
               core::InputError);
}

TEST(ThresholdAt, IsReachedByTheShareAskedFor) {
  std::vector<double> known;
  for (int i = 1; i <= 20; ++i) known.push_back(i);
  EXPECT_EQ(classification::threshold_at(known, 0.95), 2);
  EXPECT_EQ(classification::threshold_at(known, 1), 1);
  EXPECT_EQ(classification::threshold_at(known, 0.15), 18);
  EXPECT_EQ(classification::threshold_at(known, 1e-9), 20);
  EXPECT_EQ(classification::fraction_reaching(std::vector<double>{1, 2, 3, 0}, 2), 0.5);
  EXPECT_TRUE(std::isnan(classification::fraction_reaching({}, 2)));
  EXPECT_THROW(classification::threshold_at({}, 0.95), core::InputError);
  EXPECT_THROW(classification::threshold_at(known, 0), core::InputError);
  EXPECT_THROW(classification::threshold_at(known, 1.01), core::InputError);
  EXPECT_TRUE(rc::check("the greatest such threshold", [] {
    const auto scores = any_scores();
    const double rate = *rc::gen::inRange(1, 101) / 100.0;
    const double threshold = classification::threshold_at(scores, rate);
    RC_ASSERT(classification::fraction_reaching(scores, threshold) >= rate - 1e-9);
    RC_ASSERT(classification::fraction_reaching(scores, std::nextafter(threshold, infinity)) <
              rate);
  }));
}

TEST(LogOdds, AreThoseOfTheProbabilities) {
  // p = scipy.special.softmax(z / T, axis=1).max(1); numpy.log(p / (1 - p))
  const std::vector<double> z = {2, 1, 0, 0.5, 2.5, -1}, shifted = {7, 6, 5};
  EXPECT_NEAR(classification::log_odds_scores({z, 3})[0], 0.68673831, 1e-8);
  EXPECT_NEAR(classification::log_odds_scores({z, 3})[1], 1.79858672, 1e-8);
  EXPECT_NEAR(classification::log_odds_scores({z, 3}, 2)[0], 0.02592302, 1e-8);
  EXPECT_NEAR(classification::log_odds_scores({shifted, 3})[0], 0.68673831, 1e-8);
  // Where probabilities are 1 there is still an order.
  const std::vector<double> sure = {80, 0, 90, 0};
  EXPECT_EQ(classification::log_odds_scores({sure, 2}), (std::vector<double>{80, 90}));
  EXPECT_THROW(classification::log_odds_scores({std::vector{infinity, 0.0}, 2}), core::InputError);
  EXPECT_THROW(classification::log_odds_scores({z, 3}, 0), core::InputError);
  EXPECT_THROW(classification::log_odds_scores({z, 1}), core::InputError);
}

}  // namespace
}  // namespace carillon::eval
