#include "eval/material/loudness.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "tests/eval/struck_bodies.hpp"

namespace carillon::eval {
namespace {

features::Feature tone(double frequency, double decay_rate, double amplitude) {
  features::Feature feature;
  feature.frequency = frequency;
  feature.decay_rate = decay_rate;
  feature.amplitude = amplitude;
  return feature;
}

double sum_of_frame(const material::BandPowers& powers, const material::SpectrogramGrid& grid,
                    std::size_t frame) {
  const auto begin = powers.begin() + static_cast<std::ptrdiff_t>(frame * grid.bands);
  return std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(grid.bands), 0.0);
}

TEST(BandPowers, OfALastingToneAreHalfItsSquare) {
  for (const double rate : {8000.0, 44100.0, 192000.0}) {
    const auto grid = material::make_grid(static_cast<std::size_t>(rate), rate, 0);
    const auto clip = test::record({tone(1000, 0, 0.3)}, {.seconds = 1, .sample_rate = rate});
    const material::BandPowers heard = material::band_powers(clip.samples, grid);
    const material::BandPowers known = material::band_powers(std::vector{tone(1000, 0, 0.3)}, grid);
    for (std::size_t m = 0; m < grid.frames; ++m) {
      EXPECT_NEAR(sum_of_frame(heard, grid, m), 0.045, 1e-5) << rate;
      EXPECT_NEAR(sum_of_frame(known, grid, m), 0.045, 1e-5) << rate;
    }
    // 1 kHz is 8.5 Bark.
    EXPECT_GT(known[8], 0.044) << rate;
  }
}

TEST(BandPowers, OfTonesAreThoseOfTheirClip) {
  // Each tone alone, so that no beats come in; what is 70 dB below the frame's sum is not compared.
  for (const features::Feature& one : {tone(440, 3, 1), tone(3000.3, 60, 0.1), tone(9000, 400, 2),
                                       tone(150, 20, 1), tone(17000, 1000, 1)}) {
    const auto clip = test::record({one}, {.seconds = 0.5});
    const auto grid = material::make_grid(clip.samples.size(), 44100, 0);
    const material::BandPowers heard = material::band_powers(clip.samples, grid);
    const material::BandPowers known = material::band_powers(std::vector{one}, grid);
    ASSERT_EQ(heard.size(), known.size());
    for (std::size_t i = 0; i < heard.size(); ++i) {
      const double all = sum_of_frame(heard, grid, i / grid.bands);
      if (heard[i] < 1e-4 * all || all < 1e-12) continue;
      // At low frequencies the window hears the negative frequency too.
      EXPECT_NEAR(known[i] / heard[i], 1, one.frequency < 400 ? 0.05 : 0.01)
          << one.frequency << " Hz, frame " << i / grid.bands << ", band " << i % grid.bands;
    }
  }
}

TEST(BandPowers, BeginAfterTheOnset) {
  const features::Feature one = tone(800, 30, 1);
  auto grid = material::make_grid(10000, 44100, 0);
  const double at_once = material::band_powers(std::vector{one}, grid)[0];
  grid.begin = 0.1;
  EXPECT_NEAR(material::band_powers(std::vector{one}, grid)[0] / at_once, std::exp(-2 * 30 * 0.1),
              1e-9);
}

TEST(BandPowers, ClipsShorterThanAWindowHaveOneFrame) {
  const auto grid = material::make_grid(10, 44100, 0);
  EXPECT_EQ(grid.frames, 1U);
  EXPECT_EQ(material::band_powers(std::vector<double>(10, 0.5), grid).size(), grid.bands);
  EXPECT_LE(material::make_grid(10000000, 44100, 0).frames, 401U);
  EXPECT_THROW(material::make_grid(0, 44100, 0), core::InputError);
  EXPECT_THROW(material::make_grid(10, 0, 0), core::InputError);
}

/// Loudness of one band at a level [dB re 20 uPa].
double loudness_at(std::size_t band, double level, double background = -300) {
  const auto grid = material::make_grid(2000, 44100, 0);
  material::BandPowers powers(grid.bands, 0.0);
  powers[band] = 1;
  material::LoudnessScale scale;
  scale.unit_level = level;
  scale.background.assign(grid.bands, std::pow(10, (background - level) / 10));
  return material::specific_loudness(powers, grid, scale)[band];
}

TEST(SpecificLoudness, IsNothingBelowTheThreshold) {
  // Terhardt's threshold is 3.4 dB at 1 kHz and 25 dB near 100 Hz.
  EXPECT_EQ(loudness_at(8, 2), 0);
  EXPECT_GT(loudness_at(8, 6), 0);
  EXPECT_EQ(loudness_at(0, 25), 0);
  EXPECT_GT(loudness_at(0, 50), 0);
}

TEST(SpecificLoudness, FollowsZwicker) {
  // Ten decibels more are a factor of 10^0.23 far above the threshold.
  EXPECT_NEAR(loudness_at(8, 100) / loudness_at(8, 90), std::pow(10, 0.23), 0.01);
  // The middle of the band is 998.4 Hz, with a threshold T of 3.375 dB: python3 -c "print(0.08 *
  // 10**(0.023 * 3.375) * ((0.5 + 0.5 * 10**((60 - 3.375) / 10))**0.23 - 1))" gives 1.5406.
  EXPECT_NEAR(loudness_at(8, 60), 1.5406, 1e-4);
}

TEST(SpecificLoudness, HearsTonesBeforeABackground) {
  EXPECT_NEAR(loudness_at(8, 20, 60) / loudness_at(8, 60), 1, 0.01);
  EXPECT_GT(loudness_at(8, 80, 60), loudness_at(8, 80));
}

}  // namespace
}  // namespace carillon::eval
