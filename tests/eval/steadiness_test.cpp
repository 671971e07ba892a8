#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "eval/features/detail/judge_tones.hpp"

namespace carillon::eval::features {
namespace {

constexpr double rate = 44100;

std::vector<double> tone_before(double frequency, double amplitude) {
  std::vector<double> samples(static_cast<std::size_t>(0.2 * rate));
  for (std::size_t n = 0; n < samples.size(); ++n) {
    samples[n] =
        amplitude * std::sin(2 * std::numbers::pi * frequency * static_cast<double>(n) / rate);
  }
  return samples;
}

TEST(Steadiness, IsToldByWhatWasThereBefore) {
  // A slow mode that is in unison with mains, and one that was there before the strike.
  const SlowTone tone{200, 0.1, 0.05, 0.3, 2};
  EXPECT_EQ(steadiness(tone, tone_before(200, 0.01), rate), Steadiness::mode);
  EXPECT_EQ(steadiness(tone, tone_before(200, 0.25), rate), Steadiness::hum);
  EXPECT_EQ(steadiness({731, 0.1, 0.05, 0.3, 2}, tone_before(731, 0.25), rate), Steadiness::hum);
}

TEST(Steadiness, WithoutALeadInIsOfMainsOrWithoutDecay) {
  const auto of = [](double frequency, double decay_rate, double error, double duration) {
    return steadiness({frequency, decay_rate, error, 0.1, duration}, {}, rate);
  };
  EXPECT_EQ(of(100.1, 0.01, 0.05, 2), Steadiness::hum);   // twice 50 Hz, no decay to be seen
  EXPECT_EQ(of(180.2, 0.1, 0.05, 2), Steadiness::hum);    // three times 60 Hz
  EXPECT_EQ(of(100.1, 0.2, 0.01, 2), Steadiness::mode);   // decays, and surely
  EXPECT_EQ(of(131.0, 0.05, 0.05, 2), Steadiness::mode);  // no multiple
  EXPECT_EQ(of(131.0, 0.005, 0.05, 2), Steadiness::hum);  // 1 % is no decay
  EXPECT_EQ(of(131.0, -0.05, 0.05, 2), Steadiness::neither);
}

TEST(Steadiness, OfMainsIsNotWhatDecaysOrLiesHigh) {
  const auto of = [](double frequency, double decay_rate, double error, double duration) {
    return steadiness({frequency, decay_rate, error, 0.1, duration}, {}, rate);
  };
  // A rate that is not known is no sign of steadiness: this one has lost two thirds.
  EXPECT_EQ(of(700, 2.45, 1.2, 0.49), Steadiness::mode);
  // Far up every frequency is near to a multiple.
  EXPECT_EQ(of(5500.3, 0.2, 0.1, 1), Steadiness::mode);
}

}  // namespace
}  // namespace carillon::eval::features
