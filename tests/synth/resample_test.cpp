#include "synth/signal/resample.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "sound_files.hpp"
#include "welch.hpp"

namespace carillon::synth {
namespace {

TEST(Resample, KeepsFrequencyAndLevelOfTones) {
  for (const double from : {8000.0, 11025.0, 16000.0, 44100.0, 48000.0, 96000.0, 192000.0}) {
    for (const double to : {8000.0, 44100.0, 48000.0}) {
      const double top = 0.45 * std::min(from, to);
      for (const double tone : {100.0, 1000.0, top}) {
        const auto count = static_cast<std::size_t>(from / 2);
        const auto out = signal::resample(sine(count, tone, from), from, to);
        EXPECT_EQ(out.size(), static_cast<std::size_t>(std::lround(double(count) * to / from)));
        // Without the ends, beyond which there is silence.
        const auto edge = static_cast<std::ptrdiff_t>(0.05 * to);
        const std::vector<double> middle(out.begin() + edge, out.end() - edge);
        EXPECT_NEAR(tone_level(middle, tone, to), 20 * std::log10(0.5), 0.01)
            << from << " " << to << " " << tone;
        // In place, too: against the sine itself, no delay and nothing else beside it.
        const auto expected = sine(out.size(), tone, to);
        double worst = 0;
        for (std::size_t i = std::size_t(edge); i + std::size_t(edge) < out.size(); ++i) {
          worst = std::max(worst, std::abs(out[i] - expected[i]));
        }
        // At nine tenths of the band the filter begins to fall: 0.01 dB.
        EXPECT_LT(worst, 0.5 * (tone < top ? 1e-5 : 1e-3)) << from << " " << to << " " << tone;
      }
    }
  }
}

TEST(Resample, RemovesWhatWouldAlias) {
  for (const double tone : {5000.0, 7000.0, 12000.0, 21000.0}) {
    const auto out = signal::resample(sine(44100, tone, 44100), 44100, 8000);
    double worst = 0;
    for (std::size_t i = 400; i + 400 < out.size(); ++i) worst = std::max(worst, std::abs(out[i]));
    EXPECT_LT(20 * std::log10(worst / 0.5), -90) << tone;
  }
  // Upwards: no image above half the old rate.
  const auto out = signal::resample(sine(8000, 3000, 8000), 8000, 44100);
  const std::vector<double> middle(out.begin() + 2000, out.end() - 2000);
  EXPECT_LT(tone_level(middle, 5000, 44100) - 20 * std::log10(0.5), -90);
}

TEST(Resample, EqualRatesChangeNothing) {
  const auto samples = some_noise(1000, 1);
  EXPECT_EQ(signal::resample(samples, 44100, 44100), samples);
  EXPECT_EQ(signal::resample(samples, 44100, 48000), signal::resample(samples, 44100, 48000));
}

TEST(Resample, OfNothingAndOfOneSample) {
  EXPECT_TRUE(signal::resample({}, 44100, 8000).empty());
  const std::vector<double> one = {1.0};
  EXPECT_EQ(signal::resample(one, 8000, 48000).size(), 6u);
  for (double value : signal::resample(one, 8000, 48000)) EXPECT_TRUE(std::isfinite(value));
  EXPECT_TRUE(signal::resample(one, 48000, 8000).empty());
}

// Where the output's rounded length needs a sample less than there are, the end (of short ones all)
// was silent.
TEST(Resample, EndsAreThoseOfALongerSignal) {
  for (const double from : {44100.0, 48000.0, 192000.0}) {
    for (const double to : {8000.0, 16000.0, 44100.0}) {
      for (std::size_t count : {40, 999, 1000, 1001, 3000, 8000, 20000}) {
        std::vector<double> samples = some_noise(count, static_cast<unsigned>(count));
        const auto made = signal::resample(samples, from, to);
        samples.resize(count + 20000, 0.0);
        const auto longer = signal::resample(samples, from, to);
        // The last sample of a fraction may be missing.
        for (std::size_t i = 0; i + 1 < made.size(); ++i) {
          ASSERT_NEAR(made[i], longer[i], 1e-6) << from << " " << to << " " << count << " " << i;
        }
      }
    }
  }
}

TEST(Resample, RefusesImpossibleRatesAndSamples) {
  const std::vector<double> one = {1.0};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double rate : {0.0, -8000.0, nan, 1e9, 10.0, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(signal::resample(one, rate, 44100), core::InputError) << rate;
    EXPECT_THROW(signal::resample(one, 44100, rate), core::InputError) << rate;
  }
  EXPECT_THROW(signal::resample(std::vector<double>{0, nan}, 8000, 44100), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
