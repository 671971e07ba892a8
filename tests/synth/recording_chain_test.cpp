#include "synth/recording/recording_chain.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/error.hpp"

namespace carillon::synth {
namespace {

const float nan_sample = std::numeric_limits<float>::quiet_NaN();

TEST(ShiftLater, WholeSamplesOnlyMove) {
  EXPECT_TRUE(rc::check([](const std::vector<short>& values) {
    std::vector<float> clip(values.begin(), values.end());
    const auto before = clip;
    const auto by = *rc::gen::inRange<std::size_t>(0, 40);
    recording::shift_later(clip, static_cast<double>(by));
    RC_ASSERT(clip.size() == before.size());
    for (std::size_t i = 0; i < clip.size(); ++i) {
      RC_ASSERT(clip[i] == (i < by ? 0.0F : before[i - by]));
    }
  }));
}

TEST(ShiftLater, FractionsAreTheSameSoundBetweenSamples) {
  const auto tone = [](double n, double cycles) {
    // A swell of 300 samples in the middle, whose spectrum ends below 0.46 of the rate.
    const double t = (n - 1000) / 150;
    return std::exp(-t * t) * std::sin(2 * std::numbers::pi * cycles * n);
  };
  for (const double cycles : {0.01, 0.1, 0.25, 0.4, 0.44}) {
    for (const double delay : {0.5, 0.001, 0.999, 17.3, 200.75}) {
      std::vector<float> clip(2000);
      for (std::size_t i = 0; i < clip.size(); ++i) {
        clip[i] = static_cast<float>(tone(double(i), cycles));
      }
      recording::shift_later(clip, delay);
      double worst = 0;
      for (std::size_t i = 0; i < clip.size(); ++i) {
        worst = std::max(worst, std::abs(clip[i] - tone(double(i) - delay, cycles)));
      }
      EXPECT_LT(20 * std::log10(worst), -90) << cycles << " " << delay;
    }
  }
}

TEST(ShiftLater, BeyondTheEndLeavesSilence) {
  for (const double delay : {100.0, 100.5, 1e300}) {
    std::vector<float> clip(100, 1.0F);
    recording::shift_later(clip, delay);
    EXPECT_EQ(clip, std::vector<float>(100, 0.0F));
  }
  std::vector<float> clip(100, 1.0F), none;
  recording::shift_later(none, 3.5);
  for (const double delay : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(recording::shift_later(clip, delay), core::InputError);
  }
}

TEST(ApplyGain, IsInDecibels) {
  std::vector<float> clip = {1, -0.5F, 0};
  recording::apply_gain(clip, 20);
  EXPECT_EQ(clip, (std::vector<float>{10, -5, 0}));
  recording::apply_gain(clip, 0);
  EXPECT_EQ(clip, (std::vector<float>{10, -5, 0}));
  EXPECT_THROW(recording::apply_gain(clip, 800), core::InputError);
  EXPECT_THROW(recording::apply_gain(clip, std::nan("")), core::InputError);
  EXPECT_EQ(clip, (std::vector<float>{10, -5, 0}));
}

TEST(ClipAt, CountsWhatIsBeyond) {
  std::vector<float> clip = {0.2F, 0.5F, -0.5F, 0.6F, -7, 1e30F};
  EXPECT_EQ(recording::clip_at(clip, 0.5), 3u);
  EXPECT_EQ(clip, (std::vector<float>{0.2F, 0.5F, -0.5F, 0.5F, -0.5F, 0.5F}));
  EXPECT_EQ(recording::clip_at(clip, 0.5), 0u);
  EXPECT_THROW(recording::clip_at(clip, 0), core::InputError);
  EXPECT_THROW(recording::clip_at(clip, std::nan("")), core::InputError);
}

TEST(Quantise, RoundsToTheNearestStep) {
  EXPECT_TRUE(rc::check([] {
    const int bits = *rc::gen::inRange(2, 25);
    const double step = std::pow(2.0, 1 - bits);
    std::vector<float> clip(50);
    for (float& sample : clip) {
      sample = static_cast<float>(*rc::gen::inRange(-1'000'000, 1'000'000)) * 1e-6F;
    }
    const auto before = clip;
    const std::size_t beyond = recording::quantise(clip, bits, nullptr);
    std::size_t top = 0;
    for (std::size_t i = 0; i < clip.size(); ++i) {
      RC_ASSERT(std::fmod(double(clip[i]), step) == 0.0);
      // Full scale itself is one step too high.
      const bool high = before[i] > 1 - 1.5 * step;
      RC_ASSERT(std::abs(double(clip[i]) - before[i]) <= (high ? 1.0 : 0.5) * step);
      RC_ASSERT(clip[i] <= 1 - step);
      top += before[i] > 1 - 0.5 * step;
    }
    RC_ASSERT(beyond <= top + 1);
    auto again = clip;
    RC_ASSERT(recording::quantise(again, bits, nullptr) == 0u);
    RC_ASSERT(again == clip);
  }));
}

TEST(Quantise, LimitsAndCountsWhatIsBeyondFullScale) {
  std::vector<float> clip = {1, -1, 2, -3, 0.9999F, 0};
  EXPECT_EQ(recording::quantise(clip, 8, nullptr), 4u);
  EXPECT_EQ(clip, (std::vector<float>{127.0F / 128, -1, 127.0F / 128, -1, 127.0F / 128, 0}));
}

/// Without dither the error of a constant is a constant; with TPDF its mean is 0 and its variance a
/// quarter of a step squared at every level.
TEST(Quantise, DitherMakesTheErrorIndependentOfTheSignal) {
  constexpr int bits = 8;
  const double step = 1.0 / 128;
  for (const double level : {0.0, 0.1, 0.25, 0.5, 0.77}) {
    std::vector<float> clip(100'000, static_cast<float>(level * step));
    core::RandomStream random(1, 2, "test.dither");
    recording::quantise(clip, bits, &random);
    double mean = 0, square = 0;
    for (const float sample : clip) {
      const double error = sample / step - level;
      mean += error;
      square += error * error;
    }
    EXPECT_NEAR(mean / 1e5, 0, 4 * 0.5 / std::sqrt(1e5)) << level;
    EXPECT_NEAR(square / 1e5, 0.25, 0.005) << level;
  }
}

TEST(Quantise, DitherBelongsToItsStream) {
  const auto with = [](std::uint64_t id) {
    std::vector<float> clip(100, 0.1F);
    core::RandomStream random(1, id, "test.dither");
    recording::quantise(clip, 8, &random);
    return clip;
  };
  EXPECT_EQ(with(1), with(1));
  EXPECT_NE(with(1), with(2));
}

TEST(Quantise, RefusesImpossibleBitsAndSamples) {
  std::vector<float> clip = {0.1F};
  for (int bits : {-1, 0, 1, 25, 32})
    EXPECT_THROW(recording::quantise(clip, bits, nullptr), core::InputError);
  clip[0] = nan_sample;
  EXPECT_THROW(recording::quantise(clip, 16, nullptr), core::InputError);
}

TEST(SilentAfterRounding, IsWhatQuantisationLeaves) {
  EXPECT_TRUE(rc::check([] {
    std::vector<float> clip(5);
    for (float& sample : clip) {
      sample = static_cast<float>(*rc::gen::inRange(-30, 30)) / 40 / 32768;
    }
    const bool silent = recording::silent_after_rounding(clip, 16);
    recording::quantise(clip, 16, nullptr);
    RC_ASSERT(silent == (clip == std::vector<float>(5, 0.0F)));
  }));
  EXPECT_FALSE(recording::silent_after_rounding(std::vector<float>{nan_sample}, 16));
}

}  // namespace
}  // namespace carillon::synth
