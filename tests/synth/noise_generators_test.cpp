#include "synth/recording/noise_generators.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/error.hpp"
#include "welch.hpp"

namespace carillon::synth {
namespace {

std::vector<double> noise(recording::NoiseKind kind, std::size_t count, double rate,
                          std::uint64_t item = 1) {
  core::RandomStream random(7, item, "test.noise");
  return recording::generate_noise(kind, count, rate, random);
}

/// Largest deviation [dB] of the levels of half octaves from a straight line of `slope` dB per
/// octave through 1 kHz.
double deviation(recording::NoiseKind kind, double slope, double rate, double low, double high) {
  constexpr std::size_t window = 1 << 15;
  const auto power = welch(noise(kind, 60 * window, rate), window);
  const double bin = rate / window;
  const double reference = band_level(power, bin, 800, 1250);
  double worst = 0;
  for (double f = low; f * std::sqrt(2.0) < high; f *= std::sqrt(2.0)) {
    // Expected from the line's own mean over the band, as levels fall within it.
    double sum = 0, centre = 0;
    int count = 0, centre_count = 0;
    for (std::size_t k = 1; k < power.size(); ++k) {
      const double frequency = static_cast<double>(k) * bin;
      const double line = std::pow(frequency, slope / (10 * std::log10(2.0)));
      if (frequency >= f && frequency < f * std::sqrt(2.0)) sum += line, ++count;
      if (frequency >= 800 && frequency < 1250) centre += line, ++centre_count;
    }
    const double expected = reference + 10 * std::log10((sum / count) / (centre / centre_count));
    worst = std::max(worst, std::abs(band_level(power, bin, f, f * std::sqrt(2.0)) - expected));
  }
  return worst;
}

// A half octave at f holds 0.35 f / 1.35 Hz bins of 119 windows of which about 100 are independent:
// at 100 Hz 26 bins, whose mean is right within 0.09 dB (one standard deviation).
TEST(GeneratedNoise, SlopesAreThoseOfTheNames) {
  EXPECT_LT(deviation(recording::NoiseKind::white, 0, 44100, 80, 21000), 0.4);
  EXPECT_LT(deviation(recording::NoiseKind::pink, -10 * std::log10(2.0), 44100, 80, 21000), 0.4);
  EXPECT_LT(deviation(recording::NoiseKind::brown, -20 * std::log10(2.0), 44100, 80, 21000), 0.5);
}

TEST(GeneratedNoise, SlopesHoldAtOtherRates) {
  EXPECT_LT(deviation(recording::NoiseKind::pink, -10 * std::log10(2.0), 8000, 80, 3800), 0.4);
  EXPECT_LT(deviation(recording::NoiseKind::brown, -20 * std::log10(2.0), 96000, 200, 45000), 0.5);
}

TEST(GeneratedNoise, BabbleHasTheSpectrumOfSpeech) {
  constexpr std::size_t window = 1 << 14;
  const auto power = welch(noise(recording::NoiseKind::babble, 200 * window, 44100), window);
  const auto level = [&](double f) {
    return band_level(power, 44100.0 / window, 0.9 * f, 1.1 * f);
  };
  EXPECT_NEAR(level(250) - level(500), 0, 1);
  EXPECT_NEAR(level(2000) - level(4000), 12, 1);
  EXPECT_NEAR(level(1000) - level(300), -3, 1);
  EXPECT_NEAR(level(50) - level(300), -12.3, 1.5);
}

TEST(GeneratedNoise, BabbleRisesAndFallsAsSyllablesDo) {
  constexpr double rate = 1000;
  core::RandomStream random(3, 1, "test.envelope");
  auto one = recording::babble_envelope(1, 400'000, rate, random);
  auto many = recording::babble_envelope(16, 400'000, rate, random);
  const auto spread = [](std::vector<double>& envelope) {
    for (double& value : envelope) value *= value;
    const double mean =
        std::accumulate(envelope.begin(), envelope.end(), 0.0) / double(envelope.size());
    double sum = 0;
    for (double value : envelope) sum += (value - mean) * (value - mean);
    return std::pair{mean, std::sqrt(sum / double(envelope.size())) / mean};
  };
  const auto [mean_one, spread_one] = spread(one);
  const auto [mean_many, spread_many] = spread(many);
  EXPECT_NEAR(mean_one, 1, 0.1);
  EXPECT_NEAR(mean_many, 1, 0.05);
  // Independent talkers: the relative spread of their sum falls as one over the root.
  EXPECT_NEAR(spread_one / spread_many, 4, 0.4);
  // Syllables come 4 times a second (0.235 s): most of the modulation lies between 2 and 8 Hz.
  const auto power = welch(one, 1 << 12);
  const double bin = rate / (1 << 12);
  EXPECT_GT(band_level(power, bin, 3, 6), band_level(power, bin, 12, 24) + 10);
  const auto zeros = std::count(one.begin(), one.end(), 0.0);
  EXPECT_NEAR(double(zeros) / double(one.size()), 0.2, 0.04);
}

TEST(GeneratedNoise, HumIsLinesAtMultiplesOfTheMains) {
  int fifties = 0;
  for (std::uint64_t item = 0; item < 20; ++item) {
    const auto samples = noise(recording::NoiseKind::hum, 1 << 17, 44100, item);
    const auto power = welch(samples, 1 << 16);
    const double bin = 44100.0 / (1 << 16);
    const bool fifty = band_level(power, bin, 48, 52) > band_level(power, bin, 58, 62);
    fifties += fifty;
    const double mains = fifty ? 50 : 60;
    for (int h = 1; h < 5; ++h) {
      EXPECT_GT(band_level(power, bin, h * mains - 3, h * mains + 3),
                band_level(power, bin, (h + 0.4) * mains, (h + 0.6) * mains) + 50);
    }
    double sum = 0;
    for (double sample : samples) sum += sample * sample;
    EXPECT_NEAR(sum / double(samples.size()), 1, 0.02);
  }
  EXPECT_GT(fifties, 3);
  EXPECT_LT(fifties, 17);
}

/// Correlation of a clip's beginning with its end, where circular noise would have one.
TEST(GeneratedNoise, NeitherSwellsUpNorBitesItsTail) {
  for (const recording::NoiseKind kind :
       {recording::NoiseKind::white, recording::NoiseKind::pink, recording::NoiseKind::brown}) {
    double first = 0, last = 0, product = 0;
    for (std::uint64_t item = 0; item < 4000; ++item) {
      const auto samples = noise(kind, 4000, 8000, item);
      first += samples.front() * samples.front();
      last += samples.back() * samples.back();
      product += samples.front() * samples.back();
    }
    EXPECT_NEAR(first / last, 1, 0.15) << recording::noise_kind_names()[std::size_t(kind)];
    EXPECT_LT(std::abs(product) / std::sqrt(first * last), 0.07)
        << recording::noise_kind_names()[std::size_t(kind)];
  }
}

TEST(GeneratedNoise, BelongsToItsStream) {
  for (const auto& name : recording::noise_kind_names()) {
    const recording::NoiseKind kind = recording::noise_kind(name);
    EXPECT_EQ(noise(kind, 500, 44100, 1), noise(kind, 500, 44100, 1)) << name;
    EXPECT_NE(noise(kind, 500, 44100, 1), noise(kind, 500, 44100, 2)) << name;
    EXPECT_EQ(noise(kind, 0, 44100).size(), 0u) << name;
    EXPECT_EQ(noise(kind, 1, 44100).size(), 1u) << name;
    for (double sample : noise(kind, 2000, 1000)) EXPECT_TRUE(std::isfinite(sample)) << name;
    for (double rate : {0.0, -1.0, 999.0, 1.1e7, std::nan("")}) {
      EXPECT_THROW(noise(kind, 10, rate), core::InputError) << name << rate;
    }
  }
}

TEST(GeneratedNoise, UnknownKindsAreNamedWithTheNearest) {
  try {
    recording::noise_kind("pnik");
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("did you mean \"pink\"?"), std::string::npos);
    EXPECT_NE(error.hint().find("white, pink, brown, hum, babble"), std::string::npos);
  }
}

/// Amplitude of a frequency in a second of noise.
double amplitude_at(std::span<const double> samples, double frequency, double rate) {
  double re = 0, im = 0;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const double phase = 2 * M_PI * frequency * static_cast<double>(n) / rate;
    re += samples[n] * std::cos(phase);
    im += samples[n] * std::sin(phase);
  }
  return std::hypot(re, im) / static_cast<double>(samples.size());
}

TEST(NoiseRows, OfHumHaveOneMains) {
  int fifty = 0;
  for (std::uint64_t item = 0; item < 20; ++item) {
    core::RandomStream random(3, item, "test");
    const auto rows = recording::generate_rows(recording::NoiseKind::hum, 8000, 3, 8000, random);
    ASSERT_EQ(rows.size(), 24000U);
    int low = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      const auto one = std::span(rows).subspan(row * 8000, 8000);
      low += amplitude_at(one, 50, 8000) > amplitude_at(one, 60, 8000);
    }
    EXPECT_TRUE(low == 0 || low == 3) << item;
    fifty += low == 3;
    EXPECT_NE(rows[0], rows[8000]);
  }
  EXPECT_GT(fifty, 0);
  EXPECT_LT(fifty, 20);
}

}  // namespace
}  // namespace carillon::synth
