#include "eval/classification/intervals.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "core/error.hpp"
#include "core/numbers.hpp"

namespace carillon::eval {
namespace {

using Classes = std::vector<std::size_t>;

TEST(WilsonInterval, IsSciPys) {
  // scipy.stats.binomtest(k, n).proportion_ci(method='wilson')
  core::Range bounds = classification::wilson_interval(8, 10);
  EXPECT_NEAR(bounds.low, 0.4901624715366418, 1e-12);
  EXPECT_NEAR(bounds.high, 0.9433178485456248, 1e-12);
  bounds = classification::wilson_interval(137, 200);
  EXPECT_NEAR(bounds.low, 0.6176504391426965, 1e-12);
  EXPECT_NEAR(bounds.high, 0.7453767900977148, 1e-12);
  bounds = classification::wilson_interval(0, 20);
  EXPECT_EQ(bounds.low, 0);
  EXPECT_NEAR(bounds.high, 0.16112515805281935, 1e-12);
}

TEST(WilsonInterval, HasStatedEnds) {
  EXPECT_EQ(classification::wilson_interval(0, 0).low, 0);
  EXPECT_EQ(classification::wilson_interval(0, 0).high, 1);
  EXPECT_EQ(classification::wilson_interval(5, 5).high, 1);
  EXPECT_THROW(classification::wilson_interval(3, 2), core::InputError);
  EXPECT_THROW(classification::wilson_interval(-1, 2), core::InputError);
  EXPECT_THROW(classification::wilson_interval(1, 2, 1), core::InputError);
  EXPECT_THROW(classification::wilson_interval(std::nan(""), 2), core::InputError);
}

TEST(WilsonInterval, SolvesItsEquation) {
  EXPECT_TRUE(rc::check("(share - p)^2 = z^2 p (1 - p) / n at both ends", [] {
    const double samples = *rc::gen::inRange(1, 5000);
    const double fraction = *rc::gen::inRange(0, 1001) / 1000.0;
    const core::Range bounds = classification::wilson_interval(fraction * samples, samples);
    for (const double p : {bounds.low, bounds.high}) {
      RC_ASSERT(std::abs(std::pow(fraction - p, 2) -
                         std::pow(1.959963984540054, 2) * p * (1 - p) / samples) < 1e-12);
    }
    const core::Range wrong = classification::wilson_interval((1 - fraction) * samples, samples);
    RC_ASSERT(std::abs(wrong.low - (1 - bounds.high)) < 1e-12);
  }));
}

/// Objects of two classes, each with a chance of its own to be recognised and `each` samples.
struct Bodies {
  Classes truth, groups;
  std::vector<double> chances;

  Bodies(std::size_t count, std::size_t each, core::RandomStream& random) {
    for (std::size_t g = 0; g < count; ++g) {
      chances.push_back(random.uniform(0.4, 1));
      truth.insert(truth.end(), each, g % 2);
      groups.insert(groups.end(), each, 1000 + 7 * g);
    }
  }

  /// @param shift  of all chances, a classifier's own
  Classes predict(double shift, core::RandomStream& random) const {
    Classes predicted;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const double chance = chances[(groups[i] - 1000) / 7] + shift;
      predicted.push_back(random.uniform() < chance ? truth[i] : 1 - truth[i]);
    }
    return predicted;
  }

  classification::TestedSamples tested() const { return {truth, groups, 2}; }
};

TEST(GroupedInterval, HoldsTheTruthWhereWilsonsDoesNot) {
  // 20 objects with 50 sounds each; recognised in 0.7 of all that there could be.
  int held = 0, held_balanced = 0, held_by_wilson = 0;
  constexpr int repetitions = 300;
  for (int r = 0; r < repetitions; ++r) {
    core::RandomStream random(5, static_cast<std::uint64_t>(r), "test.grouped");
    const Bodies bodies(20, 50, random);
    const Classes predicted = bodies.predict(0, random);
    const auto holds = [](core::Range bounds) { return bounds.low <= 0.7 && 0.7 <= bounds.high; };
    held += holds(classification::grouped_interval(
        bodies.tested(), predicted, classification::AccuracyKind::plain, random, 0.95, 500));
    held_balanced += holds(classification::grouped_interval(
        bodies.tested(), predicted, classification::AccuracyKind::balanced, random, 0.95, 500));
    double right = 0;
    for (std::size_t i = 0; i < predicted.size(); ++i) right += predicted[i] == bodies.truth[i];
    held_by_wilson +=
        holds(classification::wilson_interval(right, static_cast<double>(predicted.size())));
  }
  // Binomial deviation of 300 at 0.95: 0.013.
  EXPECT_GT(held, 0.91 * repetitions);
  EXPECT_LT(held, 0.99 * repetitions);
  EXPECT_GT(held_balanced, 0.91 * repetitions);
  EXPECT_LT(held_by_wilson, 0.75 * repetitions);
}

TEST(GroupedInterval, OfGroupsOfOneIsNearWilsons) {
  core::RandomStream random(1, 1, "test.grouped");
  Classes truth(400, 0), groups(400), predicted(400, 0);
  for (std::size_t i = 0; i < 400; ++i) {
    groups[i] = i;
    predicted[i] = i % 4 == 0;
  }
  const core::Range bounds = classification::grouped_interval(
      {truth, groups, 2}, predicted, classification::AccuracyKind::plain, random);
  EXPECT_NEAR(bounds.low, classification::wilson_interval(300, 400).low, 0.006);
  EXPECT_NEAR(bounds.high, classification::wilson_interval(300, 400).high, 0.006);
  core::RandomStream again(1, 1, "test.grouped");
  EXPECT_EQ(classification::grouped_interval({truth, groups, 2}, predicted,
                                             classification::AccuracyKind::plain, again)
                .low,
            bounds.low);
}

TEST(GroupedInterval, OfAllRightIsAsWideAsItsGroupsAreFew) {
  core::RandomStream random(1, 2, "test.grouped");
  const Classes truth(100, 1);
  Classes groups(100);
  for (std::size_t i = 0; i < 100; ++i) groups[i] = i % 4;
  core::Range bounds = classification::grouped_interval(
      {truth, groups, 3}, truth, classification::AccuracyKind::balanced, random);
  EXPECT_EQ(bounds.low, classification::wilson_interval(4, 4).low);
  EXPECT_EQ(bounds.high, 1);
  // One object says as much as one sample.
  bounds = classification::grouped_interval({truth, Classes(100, 9), 3}, truth,
                                            classification::AccuracyKind::plain, random);
  EXPECT_EQ(bounds.low, classification::wilson_interval(1, 1).low);
}

TEST(GroupedInterval, RefusesWhatDoesNotFit) {
  core::RandomStream random(1, 3, "test.grouped");
  const Classes two = {0, 1}, one = {0};
  const auto kind = classification::AccuracyKind::plain;
  EXPECT_THROW(classification::grouped_interval({two, one, 2}, two, kind, random),
               core::InputError);
  EXPECT_THROW(classification::grouped_interval({two, two, 2}, one, kind, random),
               core::InputError);
  EXPECT_THROW(classification::grouped_interval({two, two, 1}, two, kind, random),
               core::InputError);
  EXPECT_THROW(classification::grouped_interval({two, two, 2}, two, kind, random, 0),
               core::InputError);
  EXPECT_THROW(classification::grouped_interval({{}, {}, 2}, {}, kind, random), core::InputError);
  EXPECT_THROW(classification::interval_over_seeds({two, two, 2}, {}, kind), core::InputError);
}

TEST(IntervalOverSeeds, IsStudentsByHand) {
  // Three seeds with 14, 16 and 15 of 20 right; objects of one sample each.
  const Classes truth(20, 0);
  Classes groups(20);
  std::vector<Classes> predicted(3, Classes(20, 1));
  const std::size_t right[] = {14, 16, 15};
  for (std::size_t i = 0; i < 20; ++i) {
    groups[i] = i;
    for (std::size_t s = 0; s < 3; ++s) predicted[s][i] = i < right[s] ? 0 : 1;
  }
  const auto summary = classification::interval_over_seeds({truth, groups, 2}, predicted,
                                                           classification::AccuracyKind::plain);
  EXPECT_NEAR(summary.mean, 0.75, 1e-15);
  EXPECT_NEAR(summary.deviation, 0.05, 1e-15);
  // 14 objects are right in all seeds, one in two, one in one, four in none: their mean squared
  // deviation from 0.75 over 19 is the variance of the mean over objects.
  const double squares =
      14 * 0.0625 + std::pow(2.0 / 3 - 0.75, 2) + std::pow(1.0 / 3 - 0.75, 2) + 4 * 0.5625;
  const double of_objects = squares / 19 / 20, of_seeds = 0.0025 / 3;
  const double freedom =
      std::pow(of_objects + of_seeds, 2) / (of_objects * of_objects / 19 + of_seeds * of_seeds / 2);
  EXPECT_NEAR(freedom, 20.985126938700745, 1e-9);
  // scipy.stats.t.ppf(0.975, freedom)
  const double half = 2.0797035946060807 * std::sqrt(of_objects + of_seeds);
  EXPECT_NEAR(summary.seeds_and_groups.low, 0.75 - half, 1e-9);
  EXPECT_NEAR(summary.seeds_and_groups.high, 0.75 + half, 1e-9);
}

TEST(IntervalOverSeeds, HoldsTheTruthOfOtherBodiesAndSeeds) {
  int held = 0;
  constexpr int repetitions = 400;
  for (int r = 0; r < repetitions; ++r) {
    core::RandomStream random(6, static_cast<std::uint64_t>(r), "test.seeds");
    const Bodies bodies(16, 20, random);
    std::vector<Classes> predicted;
    for (int s = 0; s < 5; ++s) {
      predicted.push_back(bodies.predict(random.uniform(-0.1, 0), random));
    }
    const auto summary = classification::interval_over_seeds(
        bodies.tested(), predicted, classification::AccuracyKind::balanced);
    const auto holds = [](core::Range bounds) { return bounds.low <= 0.65 && 0.65 <= bounds.high; };
    held += holds(summary.seeds_and_groups);
  }
  EXPECT_GT(held, 0.92 * repetitions);
  EXPECT_LT(held, 0.99 * repetitions);
}

TEST(AccuracyDifference, HoldsTheTruthWhereTwoIntervalsOverlap) {
  // Both find the same objects hard; the first is right 0.06 less often.
  int held = 0, overlapping = 0;
  double width = 0;
  constexpr int repetitions = 300;
  for (int r = 0; r < repetitions; ++r) {
    core::RandomStream random(8, static_cast<std::uint64_t>(r), "test.difference");
    const Bodies bodies(20, 100, random);
    std::vector<Classes> first, second;
    for (int s = 0; s < 3; ++s) {
      first.push_back(bodies.predict(-0.06 + random.uniform(-0.02, 0.02), random));
      second.push_back(bodies.predict(random.uniform(-0.02, 0), random));
    }
    const classification::AccuracyDifference found =
        classification::accuracy_difference(bodies.tested(), first, second);
    // Chances above 1 - 0.02 do not occur often enough to matter: 0.06 less 0.01.
    held += found.bounds.low <= -0.05 && -0.05 <= found.bounds.high;
    width += (found.bounds.high - found.bounds.low) / repetitions;
    const auto own = [&](const std::vector<Classes>& predicted) {
      return classification::interval_over_seeds(bodies.tested(), predicted,
                                                 classification::AccuracyKind::plain)
          .seeds_and_groups;
    };
    overlapping += own(first).high > own(second).low;
  }
  EXPECT_GT(held, 0.92 * repetitions);
  EXPECT_LE(held, repetitions);
  EXPECT_GT(overlapping, 0.95 * repetitions);
  EXPECT_LT(width, 0.09);
}

TEST(AccuracyDifference, IsTheTTestOfPairsByHand) {
  const Classes truth(8, 0), groups = {0, 1, 2, 3, 4, 5, 6, 7};
  const Classes first = {0, 0, 0, 0, 0, 0, 1, 1}, second = {0, 0, 0, 1, 1, 1, 0, 1};
  const classification::TestedSamples tested{truth, groups, 2};
  const auto found = classification::accuracy_difference(tested, std::vector<Classes>{first},
                                                         std::vector<Classes>{second});
  // d = numpy.array([0, 0, 0, 1, 1, 1, -1, 0]);
  // scipy.stats.t.interval(0.95, 7, loc=d.mean(), scale=d.std(ddof=1) / 8**0.5)
  EXPECT_NEAR(found.mean, 0.25, 1e-15);
  EXPECT_NEAR(found.bounds.low, -0.3411560627525748, 1e-9);
  EXPECT_NEAR(found.bounds.high, 0.8411560627525748, 1e-9);
  const auto turned = classification::accuracy_difference(tested, std::vector<Classes>{second},
                                                          std::vector<Classes>{first});
  EXPECT_EQ(turned.mean, -found.mean);
  EXPECT_EQ(turned.bounds.high, -found.bounds.low);
  const auto same = classification::accuracy_difference(tested, std::vector<Classes>{first},
                                                        std::vector<Classes>{first});
  EXPECT_EQ(same.mean, 0);
  EXPECT_TRUE(std::isnan(same.bounds.low));
}

TEST(IntervalOverSeeds, SaysWhatCannotBeKnown) {
  const Classes truth = {0, 0, 1, 1}, groups = {0, 0, 1, 1}, wrong = {1, 0, 1, 1};
  const auto kind = classification::AccuracyKind::balanced;
  auto summary =
      classification::interval_over_seeds({truth, groups, 2}, std::vector<Classes>{wrong}, kind);
  EXPECT_EQ(summary.mean, 0.75);
  EXPECT_TRUE(std::isnan(summary.deviation));
  EXPECT_TRUE(std::isnan(summary.seeds_and_groups.high));
  summary = classification::interval_over_seeds({truth, Classes(4, 0), 2},
                                                std::vector<Classes>{wrong, truth}, kind);
  EXPECT_TRUE(std::isnan(summary.seeds_and_groups.low));
  summary = classification::interval_over_seeds({truth, groups, 2},
                                                std::vector<Classes>{truth, truth}, kind);
  EXPECT_EQ(summary.seeds_and_groups.low, classification::wilson_interval(2, 2).low);
}

}  // namespace
}  // namespace carillon::eval
