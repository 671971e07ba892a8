#include "synth/signal/convolution.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::synth {
namespace {

TEST(Convolver, IsTheSumOfDelayedClips) {
  core::RandomStream random(3, 1, "test");
  for (const std::size_t clip : {1UL, 2UL, 100UL, 333UL}) {
    for (const std::size_t length : {1UL, 7UL, 333UL, 1000UL}) {
      std::vector<float> dry(clip);
      std::vector<double> response(length);
      for (float& v : dry) v = static_cast<float>(random.normal());
      for (double& v : response) v = random.normal();
      std::vector<float> output = dry;
      signal::Convolver convolver;
      convolver.add(dry, convolver.prepare(response, clip), output);
      for (std::size_t n = 0; n < clip; ++n) {
        double sum = static_cast<double>(dry[n]);
        for (std::size_t k = 0; k <= n && k < length; ++k) {
          sum += response[k] * static_cast<double>(dry[n - k]);
        }
        ASSERT_NEAR(output[n], sum, 1e-5 * (1 + std::abs(sum)))
            << clip << " " << length << " " << n;
      }
    }
  }
}

TEST(Convolver, TheClipMayBeItsOwnOutput) {
  std::vector<float> clip = {1, 0, 0, 0};
  signal::Convolver convolver;
  convolver.add(clip, convolver.prepare(std::vector<double>{0, 0.5, 0.25}, 4), clip);
  EXPECT_NEAR(clip[0], 1, 1e-7);
  EXPECT_NEAR(clip[1], 0.5, 1e-7);
  EXPECT_NEAR(clip[2], 0.25, 1e-7);
}

TEST(Convolver, SilenceChangesNothing) {
  std::vector<float> clip = {1, -0.25F, 3e-30F};
  const auto before = clip;
  signal::Convolver convolver;
  convolver.add(clip, convolver.prepare(std::vector<double>(3, 0.0), 3), clip);
  EXPECT_EQ(clip, before);
  convolver.add(clip, convolver.prepare({}, 3), clip);
  EXPECT_EQ(clip, before);
}

TEST(Convolver, RefusesAClipOfAnotherLength) {
  signal::Convolver convolver;
  const auto response = convolver.prepare(std::vector<double>{1}, 4);
  std::vector<float> clip(5);
  EXPECT_THROW(convolver.add(clip, response, clip), core::InputError);
}

TEST(GoodFftSize, HasSmallFactorsAndIsNotMuchLonger) {
  EXPECT_EQ(signal::good_fft_size(0), 2U);
  EXPECT_EQ(signal::good_fft_size(88199), 88200U);
  for (std::size_t n = 1; n < 3000; n += 7) {
    const std::size_t size = signal::good_fft_size(n);
    EXPECT_GE(size, n);
    EXPECT_LE(size, 2 * n + 2);
    EXPECT_EQ(size % 2, 0U);
  }
}

}  // namespace
}  // namespace carillon::synth
