#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "eval/features/detail/crowding.hpp"
#include "eval/features/extract_features.hpp"
#include "tests/eval/strike_clip.hpp"

namespace carillon::eval {
namespace {

features::Feature mode_at(double frequency, double decay_rate) {
  features::Feature feature;
  feature.frequency = frequency;
  feature.decay_rate = decay_rate;
  feature.amplitude = 1;
  feature.frequency_error = 0.01;
  feature.decay_rate_error = 0.02;
  feature.amplitude_error = 0.03;
  feature.snr = 60;
  return feature;
}

TEST(Crowding, IsNoneOfALoneMode) {
  std::vector<features::Feature> one = {mode_at(1000, 20)};
  EXPECT_EQ(features::crowding(one, 0), 0);
  features::widen_crowded(one);
  EXPECT_EQ(one[0].frequency_error, 0.01);
  EXPECT_EQ(one[0].decay_rate_error, 0.02);
  EXPECT_EQ(one[0].amplitude_error, 0.03);
}

TEST(Crowding, IsTheLinesWidthTimesTheDensity) {
  // A comb of many modes s apart has 1 / s per hertz; a line is d / pi wide.
  constexpr double d = 60, spacing = 40;
  std::vector<features::Feature> comb;
  for (int k = 0; k < 801; ++k) comb.push_back(mode_at(1000 + spacing * k, d));
  const double line = d / std::numbers::pi;
  const double alone = 1 / (2.5 * std::numbers::pi);  // what the mode itself would count
  EXPECT_NEAR(features::crowding(comb, 400), line / spacing - alone, 0.03);
  // Two in one place are a Lorentzian's top.
  const std::vector<features::Feature> pair = {mode_at(1000, d), mode_at(1000, d)};
  EXPECT_NEAR(features::crowding(pair, 0), alone, 1e-12);
}

TEST(Crowding, IsLittleOfAStrongModeAmongWeakOnes) {
  std::vector<features::Feature> modes;
  for (int k = -10; k <= 10; ++k) modes.push_back(mode_at(1000 + 10 * k, 60));
  const double alike = features::crowding(modes, 10);
  for (features::Feature& mode : modes) mode.amplitude = 0.1;
  modes[10].amplitude = 1;
  EXPECT_NEAR(features::crowding(modes, 10), 0.1 * alike, 0.1);
  EXPECT_LT(features::crowding(modes, 10), features::crowding(modes, 9));
}

TEST(Crowding, MakesNoRateUnknown) {
  std::vector<features::Feature> modes;
  for (int k = 0; k < 20; ++k) modes.push_back(mode_at(1000 + k, 60));
  for (features::Feature& mode : modes) mode.snr = 10;
  features::widen_crowded(modes);
  for (const features::Feature& mode : modes) EXPECT_LT(mode.decay_rate_error, mode.decay_rate);
}

TEST(Crowding, LeavesModesThatAreFarApartAsTheyWere) {
  std::vector<features::Feature> sparse;
  for (int k = 0; k < 20; ++k) sparse.push_back(mode_at(500 * (k + 1), 5));
  features::widen_crowded(sparse);
  for (const features::Feature& mode : sparse) EXPECT_LT(mode.frequency_error, 1.001 * 0.01);
}

/// Modes drawn in a band, with decay rates and levels (20 dB) even in their logarithms.
struct DenseModes {
  std::size_t count;
  double low, high;         // Hz
  double slowest, fastest;  // 1/s
};

class Dense : public testing::TestWithParam<DenseModes> {};

TEST_P(Dense, ErrorsHold) {
  const auto [count, low, high, slowest, fastest] = GetParam();
  std::size_t given = 0, held_frequencies = 0, held_rates = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    TestRandom random(1000 * count + seed);
    std::vector<Partial> partials;
    for (std::size_t k = 0; k < count; ++k) {
      partials.push_back(
          {random.uniform(low, high), slowest * std::pow(fastest / slowest, random.uniform()),
           std::pow(10, random.uniform(-1, 0)), random.uniform(0, 2 * std::numbers::pi)});
    }
    const ClipShape shape{48000, 0.65, 0.05};
    std::vector<double> samples = strike_clip(partials, shape);
    add_noise(samples, shape, 50, random);
    const features::FeatureSet set = features::extract_features(samples, shape.sample_rate);
    for (const features::Feature& found : set.features) {
      const auto away = [&](const Partial& partial) {
        return std::abs(partial.frequency - found.frequency);
      };
      const Partial& truth =
          *std::min_element(partials.begin(), partials.end(),
                            [&](const auto& a, const auto& b) { return away(a) < away(b); });
      ++given;
      held_frequencies += away(truth) < 2 * found.frequency_error ? 1U : 0U;
      held_rates +=
          std::abs(truth.decay_rate - found.decay_rate) < 2 * found.decay_rate_error ? 1U : 0U;
    }
  }
  // As many are found as lines can be told apart, and nine in ten of what is told is true: 93 to
  // 99 % over more draws (docs/features.md).
  EXPECT_GT(static_cast<double>(given), 6 * 0.4 * static_cast<double>(count));
  EXPECT_GE(static_cast<double>(held_frequencies), 0.9 * static_cast<double>(given));
  EXPECT_GE(static_cast<double>(held_rates), 0.9 * static_cast<double>(given));
  fmt::print("{} modes from {:.0f} to {:.0f} Hz: {} given, f held {}, d held {}\n", count, low,
             high, given, held_frequencies, held_rates);
}
INSTANTIATE_TEST_SUITE_P(
    Crowding, Dense,
    testing::Values(DenseModes{12, 16000, 18000, 200, 800}, DenseModes{20, 16000, 18000, 200, 800},
                    DenseModes{30, 10000, 18000, 200, 800}, DenseModes{40, 500, 8000, 20, 200},
                    DenseModes{60, 500, 18000, 60, 600}, DenseModes{20, 500, 10000, 2, 40}));

}  // namespace
}  // namespace carillon::eval
