#include "eval/perception/compare_modes.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "eval/perception/assignment.hpp"

namespace carillon::eval {
namespace {

features::Feature mode(double frequency, double decay_rate, double amplitude) {
  features::Feature one;
  one.frequency = frequency;
  one.decay_rate = decay_rate;
  one.amplitude = amplitude;
  return one;
}

const std::vector<features::Feature> bowl = {mode(523, 8, 0.8), mode(1480, 15, 1),
                                             mode(3950, 60, 0.5)};

std::vector<features::Feature> changed(std::vector<features::Feature> modes, double cents,
                                       double decay, double level) {
  for (features::Feature& one : modes) {
    one.frequency *= std::exp2(cents / 1200);
    one.decay_rate *= decay;
    one.amplitude *= std::pow(10, level / 20);
  }
  return modes;
}

TEST(CompareModes, OfASoundAgainstItselfIsNothing) {
  const perception::ModeComparison same = perception::compare_modes(bowl, bowl);
  ASSERT_EQ(same.matched.size(), 3U);
  for (const perception::MatchedMode& pair : same.matched) EXPECT_EQ(pair.reference, pair.other);
  for (const perception::JndSummary& summary : {same.pitch, same.decay, same.level}) {
    EXPECT_EQ(summary.mean, 0);
    EXPECT_EQ(summary.worst, 0);
  }
  EXPECT_EQ(same.reference_fraction, 1);
  EXPECT_EQ(same.other_fraction, 1);
  EXPECT_EQ(same.unmatched_level, -std::numeric_limits<double>::infinity());
}

TEST(CompareModes, CountsInJustNoticeableDifferences) {
  for (const double cents : {-60.0, -5.0, 1.0, 20.0}) {
    const perception::ModeComparison detuned =
        perception::compare_modes(bowl, changed(bowl, cents, 1, 0));
    ASSERT_EQ(detuned.matched.size(), 3U);
    EXPECT_NEAR(detuned.matched[0].cents, cents, 1e-9);
    EXPECT_NEAR(detuned.matched[0].pitch_jnd, std::abs(cents) / 5, 1e-9);
    EXPECT_NEAR(detuned.matched[1].pitch_jnd, std::abs(cents) / 5, 1e-9);
    // The third one is too short for more.
    EXPECT_NEAR(detuned.matched[2].pitch_jnd, std::abs(cents) / 20, 1e-9);
    EXPECT_NEAR(detuned.pitch.worst, std::abs(cents) / 5, 1e-9);
    EXPECT_NEAR(detuned.level.worst, 0, 1e-9);
    EXPECT_NEAR(detuned.decay.worst, 0, 1e-9);
  }
  for (const double factor : {1.33, 1 / 1.33}) {
    const perception::ModeComparison longer =
        perception::compare_modes(bowl, changed(bowl, 0, factor, 0));
    EXPECT_NEAR(longer.decay.mean, 1, 1e-12);
    EXPECT_NEAR(longer.decay.worst, 1, 1e-12);
    EXPECT_NEAR(longer.matched[0].decay_ratio, factor, 1e-12);
  }
  EXPECT_NEAR(perception::compare_modes(bowl, changed(bowl, 0, 1.33 * 1.33, 0)).decay.mean, 2,
              1e-12);
  for (const double gain : {-25.0, 0.5, 6.0, 70.0}) {
    const perception::ModeComparison louder =
        perception::compare_modes(bowl, changed(bowl, 0, 1, gain));
    EXPECT_NEAR(louder.matched[1].level, gain, 1e-9);
    EXPECT_NEAR(louder.level.mean, std::abs(gain), 1e-9);
    EXPECT_NEAR(louder.level.worst, std::abs(gain), 1e-9);
    EXPECT_EQ(louder.matched.size(), 3U);
  }
}

TEST(CompareModes, TakesBothOfAPairForShort) {
  // One of them rings: its pitch is heard to 5 cents.
  const auto at = [](double d) { return std::vector{mode(1000, d, 1)}; };
  const auto jnd = [&](double first, double second) {
    return perception::compare_modes(at(first), changed(at(second), 10, 1, 0))
        .matched.at(0)
        .pitch_jnd;
  };
  EXPECT_NEAR(jnd(31, 29), 2, 1e-9);
  EXPECT_NEAR(jnd(29, 31), 2, 1e-9);
  EXPECT_NEAR(jnd(31, 31), 0.5, 1e-9);
}

TEST(CompareModes, WeighsByProminence) {
  auto other = bowl;
  other[1].amplitude *= 2;
  const perception::ModeComparison one = perception::compare_modes(bowl, other);
  double weights = 0;
  for (const perception::MatchedMode& pair : one.matched) weights += pair.weight;
  EXPECT_NEAR(one.level.mean, one.matched[1].weight * 20 * std::log10(2) / weights, 1e-9);
  EXPECT_NEAR(one.level.worst, 20 * std::log10(2), 1e-9);
  // What nobody hears beside the others does not count, but is matched.
  auto faint = bowl;
  faint.push_back(mode(9000, 20, 1e-5));
  auto wrong = faint;
  wrong[3].amplitude *= 3;
  const perception::ModeComparison unheard = perception::compare_modes(faint, wrong);
  EXPECT_EQ(unheard.matched.size(), 4U);
  EXPECT_EQ(unheard.matched[3].weight, 0);
  EXPECT_EQ(unheard.level.worst, 0);
}

TEST(CompareModes, DoesNotCompareARoomsDecay) {
  auto wet = changed(bowl, 0, 3, 0);
  wet[0].reverberant = true;
  const perception::ModeComparison in_room = perception::compare_modes(bowl, wet);
  EXPECT_TRUE(std::isnan(in_room.matched[0].decay_jnd));
  EXPECT_NEAR(in_room.decay.mean, std::log(3) / std::log(1.33), 1e-9);
}

TEST(CompareModes, TellsTheEnergyOfWhatIsNotMatched) {
  // Energies a^2 / (4 d): 0.02, 1 / 60, 1 / 960.
  auto other = bowl;
  other[2].frequency *= 1.2;
  const perception::ModeComparison one = perception::compare_modes(bowl, other);
  EXPECT_EQ(one.matched.size(), 2U);
  EXPECT_EQ(one.reference_only, std::vector<std::size_t>{2});
  EXPECT_EQ(one.other_only, std::vector<std::size_t>{2});
  const double all = 0.02 + 1.0 / 60 + 1.0 / 960;
  EXPECT_NEAR(one.reference_fraction, 1 - 1.0 / 960 / all, 1e-12);
  EXPECT_NEAR(one.unmatched_level, 10 * std::log10(1.0 / 960 / all), 1e-9);
  const perception::ModeComparison none = perception::compare_modes(bowl, {});
  EXPECT_EQ(none.reference_fraction, 0);
  EXPECT_TRUE(std::isnan(none.other_fraction));
  EXPECT_EQ(none.unmatched_level, 0);
  EXPECT_TRUE(std::isnan(none.pitch.mean));
  EXPECT_TRUE(std::isnan(perception::compare_modes({}, {}).unmatched_level));
  EXPECT_THROW(perception::compare_modes(bowl, std::vector{mode(0, 1, 1)}), core::InputError);
  EXPECT_THROW(perception::compare_modes(bowl, std::vector{mode(100, 1, std::nan(""))}),
               core::InputError);
}

TEST(CompareModes, DoesNotWeighWhatIsOverBeforeItIsRecorded) {
  // Its amplitude at the onset is extrapolated over three of its time constants.
  auto guessed = bowl;
  guessed.push_back(mode(8000, 1500, 40));
  perception::ModeComparisonOptions options;
  EXPECT_LT(perception::compare_modes(bowl, guessed, options).other_fraction, 0.2);
  options.from = 0.003;
  double energy = 0;
  for (const features::Feature& one : bowl) {
    energy += std::pow(one.amplitude * std::exp(-one.decay_rate * 0.003), 2) / (4 * one.decay_rate);
  }
  const double over = std::pow(40 * std::exp(-1500 * 0.003), 2) / (4 * 1500);
  const perception::ModeComparison comparison = perception::compare_modes(bowl, guessed, options);
  EXPECT_NEAR(comparison.other_fraction, energy / (energy + over), 1e-12);
  EXPECT_GT(comparison.other_fraction, 0.99);
  // Levels are those at the onset all the same.
  EXPECT_NEAR(perception::compare_modes(bowl, changed(bowl, 0, 1.33, 3), options).level.worst, 3,
              1e-9);
}

TEST(CompareModes, KeepsNearlyEqualModesInOrder) {
  // Each is 1 Hz up; the nearest one by itself would pair 1001 with 1001 and leave 1000 to 1002.
  const std::vector<features::Feature> pair = {mode(1000, 2, 1), mode(1001, 2, 1)};
  const std::vector<features::Feature> up = {mode(1001, 2, 1), mode(1002, 2, 1)};
  const perception::ModeComparison comparison = perception::compare_modes(pair, up);
  EXPECT_EQ(comparison.matched.at(0).other, 0U);
  EXPECT_EQ(comparison.matched.at(1).other, 1U);
}

TEST(CompareModes, LeavesSurplusModesAlone) {
  // Two close modes against one: the one alike is taken.
  const std::vector<features::Feature> pair = {mode(1000, 2, 1), mode(1004, 40, 0.1)};
  const std::vector<features::Feature> one = {mode(1003, 2, 1)};
  const perception::ModeComparison comparison = perception::compare_modes(pair, one);
  ASSERT_EQ(comparison.matched.size(), 1U);
  EXPECT_EQ(comparison.matched[0].reference, 0U);
  EXPECT_EQ(comparison.reference_only, std::vector<std::size_t>{1});
}

std::vector<features::Feature> any_modes() {
  std::vector<features::Feature> modes;
  const int count = *rc::gen::inRange(0, 12);
  for (int i = 0; i < count; ++i) {
    modes.push_back(mode(*rc::gen::inRange(200, 900) + 1e-3 * *rc::gen::inRange(0, 1000),
                         0.1 * *rc::gen::inRange(1, 900), 0.001 * *rc::gen::inRange(1, 1000)));
  }
  return modes;
}

TEST(CompareModes, IsSymmetricButForSigns) {
  EXPECT_TRUE(rc::check("exchanged", [] {
    const auto a = any_modes(), b = any_modes();
    const perception::ModeComparison forth = perception::compare_modes(a, b),
                                     back = perception::compare_modes(b, a);
    RC_ASSERT(forth.matched.size() == back.matched.size());
    for (const perception::MatchedMode& pair : forth.matched) {
      const auto same = std::find_if(
          back.matched.begin(), back.matched.end(),
          [&](const perception::MatchedMode& one) { return one.reference == pair.other; });
      RC_ASSERT(same != back.matched.end());
      RC_ASSERT(same->other == pair.reference);
      RC_ASSERT(std::abs(same->cents + pair.cents) < 1e-9);
      RC_ASSERT(std::abs(same->decay_ratio * pair.decay_ratio - 1) < 1e-12);
      RC_ASSERT(std::abs(same->pitch_jnd - pair.pitch_jnd) < 1e-9);
      RC_ASSERT(std::abs(pair.cents) <= 100);
    }
    if (!forth.matched.empty()) {
      RC_ASSERT(std::abs(forth.pitch.mean - back.pitch.mean) < 1e-9);
    }
    RC_ASSERT(forth.reference_only == back.other_only);
  }));
}

TEST(BestPairs, AreTheBestOfAllPermutations) {
  EXPECT_TRUE(rc::check("brute force", [] {
    const auto rows = *rc::gen::inRange<std::size_t>(0, 6);
    const auto columns = *rc::gen::inRange<std::size_t>(0, 6);
    std::vector<double> gains;
    for (std::size_t i = 0; i < rows * columns; ++i) {
      gains.push_back(std::max(0, *rc::gen::inRange(-5, 20)));
    }
    const auto column_of = perception::best_pairs(gains, rows, columns);
    RC_ASSERT(column_of.size() == rows);
    double found = 0;
    std::vector<bool> taken(columns, false);
    for (std::size_t r = 0; r < rows; ++r) {
      if (column_of[r] == perception::unpaired) continue;
      RC_ASSERT(!taken[column_of[r]]);
      taken[column_of[r]] = true;
      RC_ASSERT(gains[r * columns + column_of[r]] > 0);
      found += gains[r * columns + column_of[r]];
    }
    // Rows beyond the columns find places that gain nothing.
    std::vector<std::size_t> order(std::max(rows, columns));
    std::iota(order.begin(), order.end(), 0);
    double best = 0;
    do {
      double sum = 0;
      for (std::size_t r = 0; r < rows; ++r) {
        if (order[r] < columns) sum += gains[r * columns + order[r]];
      }
      best = std::max(best, sum);
    } while (std::next_permutation(order.begin(), order.end()));
    RC_ASSERT(std::abs(found - best) < 1e-9);
  }));
}

TEST(BestPairs, RefusesWhatIsNoGain) {
  EXPECT_THROW(perception::best_pairs(std::vector{1.0, 2.0}, 1, 1), core::InputError);
  EXPECT_THROW(perception::best_pairs(std::vector{-1.0}, 1, 1), core::InputError);
  EXPECT_THROW(perception::best_pairs(std::vector{std::nan("")}, 1, 1), core::InputError);
  // As many modes as there can be.
  std::vector<double> many(300 * 290);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<double>(i * 7919 % 1009);
  const auto column_of = perception::best_pairs(many, 300, 290);
  EXPECT_EQ(std::count(column_of.begin(), column_of.end(), perception::unpaired), 10);
}

}  // namespace
}  // namespace carillon::eval
