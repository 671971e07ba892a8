// Draws of sounds and errors of estimators, as the synthetic validation takes them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/error.hpp"
#include "eval/validation/draw_sounds.hpp"
#include "eval/validation/estimator_errors.hpp"

namespace carillon::eval {
namespace {

TEST(DrawSounds, TakesDifferentSoundsOfOneBody) {
  const std::vector<std::vector<std::size_t>> bodies = {
      {1, 2, 3, 4, 5}, {11, 12, 13, 14}, {21, 22}};
  std::map<std::size_t, int> taken;
  for (std::uint64_t draw = 0; draw < 2000; ++draw) {
    core::RandomStream random(7, draw, "test");
    const auto sounds = validation::draw_sounds(bodies, 3, random);
    ASSERT_EQ(sounds.size(), 3u);
    EXPECT_EQ(std::set(sounds.begin(), sounds.end()).size(), 3u);
    for (const std::size_t sound : sounds) {
      EXPECT_EQ(sound / 10, sounds.front() / 10);
      ++taken[sound];
    }
  }
  // The third object has too few. Of the others each is taken as often, and each of its sounds:
  // 1000 times 3 of 5, 1000 times 3 of 4.
  ASSERT_EQ(taken.size(), 9u);
  for (const auto& [sound, times] : taken) EXPECT_NEAR(times, sound < 10 ? 600 : 750, 100) << sound;
}

TEST(DrawSounds, TakesAllWhereAllAreAskedForAndNoneWhereThereAreTooFew) {
  core::RandomStream random(7, 1, "test");
  auto all = validation::draw_sounds({{3, 1, 2}}, 3, random);
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, (std::vector<std::size_t>{1, 2, 3}));
  EXPECT_TRUE(validation::draw_sounds({{3, 1, 2}}, 4, random).empty());
}

TEST(EstimatorErrors, AreSummedUpWithoutFitsThatFailed) {
  core::RandomStream random(7, 1, "test");
  const std::vector<double> errors = {-0.5, 0.1, std::nan(""), 0.3, -0.2, 0.4};
  const validation::ErrorSummary summary = validation::summarise_errors(errors, random);
  EXPECT_EQ(summary.fits, 6u);
  EXPECT_EQ(summary.failed, 1u);
  EXPECT_DOUBLE_EQ(summary.median, 0.3);
  EXPECT_DOUBLE_EQ(summary.mean, 0.3);
  EXPECT_DOUBLE_EQ(summary.bias, 0.1);
  EXPECT_DOUBLE_EQ(summary.lower_quartile, 0.2);
  EXPECT_DOUBLE_EQ(summary.upper_quartile, 0.4);
  EXPECT_TRUE(summary.median95.low >= 0.1 && summary.median95.low <= 0.3);
  EXPECT_TRUE(summary.median95.high >= 0.3 && summary.median95.high <= 0.5);
}

TEST(EstimatorErrors, AreComparedDrawByDraw) {
  std::vector<double> near, far;
  for (int i = 1; i <= 12; ++i) {
    near.push_back(i % 2 == 0 ? 0.01 * i : -0.01 * i);
    far.push_back(0.013 * i + 0.2);
  }
  far.back() = std::nan("");
  const validation::EstimatorComparison found = validation::compare_errors(near, far);
  EXPECT_EQ(found.pairs, 11u);
  EXPECT_LT(found.median_difference, -0.2);
  EXPECT_NEAR(found.signed_rank.p, std::ldexp(2, -11), 1e-15);
  EXPECT_LT(found.welch.t, 0);
  EXPECT_LT(found.welch.p, 0.01);
  const validation::EstimatorComparison turned = validation::compare_errors(far, near);
  EXPECT_EQ(turned.signed_rank.p, found.signed_rank.p);
  EXPECT_DOUBLE_EQ(turned.welch.t, -found.welch.t);
  EXPECT_THROW(validation::compare_errors(near, std::vector{1.0}), core::InputError);
  // No error at all is not infinitely better.
  EXPECT_TRUE(std::isfinite(
      validation::compare_errors(std::vector{0.0, 0.0, 1e-9}, std::vector{0.1, 0.2, 0.1}).welch.p));
}

}  // namespace
}  // namespace carillon::eval
