#include "eval/classification/confusion_chance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/error.hpp"
#include "eval/classification/confusion.hpp"

namespace carillon::eval {
namespace {

using Classes = std::vector<std::size_t>;

/// Answers of one classifier for samples that are groups of their own, which no other set has.
struct Set {
  Classes truth, groups;
  std::vector<Classes> predicted;
  std::size_t classes = 2;

  Set(Classes true_classes, Classes answers, std::size_t class_count = 2)
      : truth(std::move(true_classes)),
        groups(truth.size()),
        predicted{std::move(answers)},
        classes(class_count) {
    static std::size_t sets = 0;
    std::iota(groups.begin(), groups.end(), 1000 * sets++);
  }
  classification::AnsweredSamples answered() const { return {{truth, groups, classes}, predicted}; }
  classification::Confusion confusion() const {
    return classification::count_confusion(truth, predicted.front(), classes);
  }
};

/// 40 samples of each class, taken for the next one with a probability.
Set drawn(const std::vector<double>& errors, core::RandomStream& random) {
  Classes truth, answers;
  for (std::size_t c = 0; c < errors.size(); ++c) {
    for (int i = 0; i < 40; ++i) {
      truth.push_back(c);
      answers.push_back(random.uniform() < errors[c] ? (c + 1) % errors.size() : c);
    }
  }
  return {truth, answers, errors.size()};
}

TEST(ConfusionNormByChance, IsThatOfAllDealsByHand) {
  // Two right and two wrong: in 2 of 6 deals one side is all right, in 4 both are alike.
  const Set right({0, 0}, {0, 0}), wrong({0, 0}, {1, 1});
  core::RandomStream random(1, 0, "test.chance");
  const auto found =
      classification::confusion_norm_by_chance(right.answered(), wrong.answered(), random, 20000);
  EXPECT_NEAR(found.mean, std::sqrt(2) / 3, 0.01);
  EXPECT_NEAR(found.max, std::sqrt(2), 1e-12);
}

TEST(ConfusionNormByChance, IsExceededInFivePercentWhereErrorsAreAlike) {
  int beyond = 0;
  constexpr int repetitions = 400;
  for (int r = 0; r < repetitions; ++r) {
    core::RandomStream random(2, static_cast<std::uint64_t>(r), "test.chance");
    const std::vector<double> errors = {0.1, 0.3, 0.5};
    const Set first = drawn(errors, random), second = drawn(errors, random);
    const double norm =
        classification::confusion_difference(first.confusion(), second.confusion()).norm;
    beyond += norm > classification::confusion_norm_by_chance(first.answered(), second.answered(),
                                                              random, 200)
                         .max;
  }
  EXPECT_GT(beyond, 0.02 * repetitions);
  EXPECT_LT(beyond, 0.085 * repetitions);
}

TEST(ConfusionNormByChance, IsExceededWhereErrorsDiffer) {
  core::RandomStream random(3, 0, "test.chance");
  const Set first = drawn({0.1, 0.1, 0.1}, random), second = drawn({0.6, 0.1, 0.1}, random);
  const double norm =
      classification::confusion_difference(first.confusion(), second.confusion()).norm;
  EXPECT_GT(
      norm,
      classification::confusion_norm_by_chance(first.answered(), second.answered(), random).max);
}

TEST(ConfusionNormByChance, KeepsAGroupTogether) {
  // Twenty samples of one group on each side are as two samples.
  Set right(Classes(20, 0), Classes(20, 0)), wrong(Classes(20, 0), Classes(20, 1));
  right.groups.assign(20, 0);
  wrong.groups.assign(20, 1);
  core::RandomStream random(4, 0, "test.chance");
  const auto found =
      classification::confusion_norm_by_chance(right.answered(), wrong.answered(), random);
  EXPECT_NEAR(found.mean, std::sqrt(2), 1e-12);
}

TEST(ConfusionNormByChance, HeedsThatClassesOfAGroupGoTogether) {
  // A strike in three materials: all of them are taken for the next, or none.
  int beyond = 0;
  constexpr int repetitions = 400;
  const auto strikes = [](std::size_t first_strike, core::RandomStream& random) {
    Set set({}, {}, 3);
    for (std::size_t strike = first_strike; strike < first_strike + 30; ++strike) {
      const std::size_t error = random.uniform() < 0.4 ? 1 : 0;
      for (std::size_t c = 0; c < 3; ++c) {
        set.truth.push_back(c);
        set.groups.push_back(strike);
        set.predicted.front().push_back((c + error) % 3);
      }
    }
    return set;
  };
  for (int r = 0; r < repetitions; ++r) {
    core::RandomStream random(6, static_cast<std::uint64_t>(r), "test.chance");
    const Set first = strikes(0, random), second = strikes(30, random);
    const double norm =
        classification::confusion_difference(first.confusion(), second.confusion()).norm;
    beyond += norm > classification::confusion_norm_by_chance(first.answered(), second.answered(),
                                                              random, 200)
                         .max;
  }
  EXPECT_LT(beyond, 0.085 * repetitions);
}

/// The same 60 strikes of each of two classes, right or wrong in both conditions together; of the
/// second condition some right ones are wrong, too.
std::pair<Set, Set> same_strikes(double also_wrong, core::RandomStream& random) {
  Set first({}, {}, 2), second({}, {}, 2);
  for (std::size_t i = 0; i < 120; ++i) {
    const bool right = random.uniform() < 0.5;
    const bool right_there = right && random.uniform() >= also_wrong;
    for (Set* set : {&first, &second}) {
      set->truth.push_back(i % 2);
      set->groups.push_back(i);
      set->predicted.front().push_back((set == &first ? right : right_there) ? i % 2 : 1 - i % 2);
    }
  }
  return {first, second};
}

TEST(ConfusionNormByChance, OfTheSameStrikesIsOfThoseThatChanged) {
  // A strike that is heard alike in both conditions makes no chance: what is left is far less than
  // that of other strikes, and a small change for the worse stands out.
  core::RandomStream random(8, 0, "test.chance");
  auto [first, second] = same_strikes(0, random);
  const auto unchanged =
      classification::confusion_norm_by_chance(first.answered(), second.answered(), random);
  EXPECT_EQ(unchanged.max, 0);
  std::tie(first, second) = same_strikes(0.25, random);
  const double norm =
      classification::confusion_difference(first.confusion(), second.confusion()).norm;
  EXPECT_GT(
      norm,
      classification::confusion_norm_by_chance(first.answered(), second.answered(), random).max);
  for (std::size_t& group : second.groups) group += 1000;  // as if they were other strikes
  EXPECT_LT(
      norm,
      classification::confusion_norm_by_chance(first.answered(), second.answered(), random).max);
}

TEST(ConfusionNormByChance, OfTheSameStrikesIsExceededInFivePercentWhereErrorsAreAlike) {
  // Some strikes are hard to tell in both conditions.
  int beyond = 0;
  constexpr int repetitions = 400;
  for (int r = 0; r < repetitions; ++r) {
    core::RandomStream random(9, static_cast<std::uint64_t>(r), "test.chance");
    Set first({}, {}, 2), second({}, {}, 2);
    for (std::size_t i = 0; i < 80; ++i) {
      const double error = random.uniform() < 0.5 ? 0.05 : 0.8;
      for (Set* set : {&first, &second}) {
        set->truth.push_back(i % 2);
        set->groups.push_back(i);
        set->predicted.front().push_back(random.uniform() < error ? 1 - i % 2 : i % 2);
      }
    }
    const double norm =
        classification::confusion_difference(first.confusion(), second.confusion()).norm;
    beyond += norm > classification::confusion_norm_by_chance(first.answered(), second.answered(),
                                                              random, 200)
                         .max;
  }
  EXPECT_GT(beyond, 0.02 * repetitions);
  EXPECT_LT(beyond, 0.085 * repetitions);
}

TEST(ConfusionNormByChance, DealsGroupsOfUnlikeClassesToo) {
  // Strikes in two materials on one side, in one on the other: alike but for chance.
  Set first({}, {}, 2), second({}, {}, 2);
  core::RandomStream random(7, 0, "test.chance");
  for (std::size_t i = 0; i < 60; ++i) {
    for (Set* set : {&first, &second}) {
      set->truth.push_back(i % 2);
      set->groups.push_back(set == &first ? i / 2 : 30 + i);
      set->predicted.front().push_back(random.uniform() < 0.3 ? 1 - i % 2 : i % 2);
    }
  }
  const double norm =
      classification::confusion_difference(first.confusion(), second.confusion()).norm;
  const auto chance =
      classification::confusion_norm_by_chance(first.answered(), second.answered(), random);
  EXPECT_LT(norm, chance.max);
  EXPECT_LT(chance.mean, chance.max);
}

TEST(ConfusionNormByChance, OfNothingInCommonIsNothing) {
  core::RandomStream random(5, 0, "test.chance");
  const Set first({0}, {0}), second({1}, {1}), other({0}, {0}, 3);
  EXPECT_TRUE(std::isnan(
      classification::confusion_norm_by_chance(first.answered(), second.answered(), random).max));
  EXPECT_THROW(classification::confusion_norm_by_chance(first.answered(), other.answered(), random),
               core::InputError);
  Set without = first;
  without.groups.clear();
  EXPECT_THROW(
      classification::confusion_norm_by_chance(first.answered(), without.answered(), random),
      core::InputError);
}

}  // namespace
}  // namespace carillon::eval
