#include "dataset/sweep/detail/sound_measures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace carillon::dataset {
namespace {

/// A decaying sine of 1 s at 44.1 kHz.
std::vector<float> ring(double frequency, double decay_rate, double amplitude) {
  std::vector<float> clip(44100);
  for (std::size_t i = 0; i < clip.size(); ++i) {
    const double t = static_cast<double>(i) / 44100;
    clip[i] = static_cast<float>(amplitude * std::exp(-decay_rate * t) *
                                 std::sin(2 * std::numbers::pi * frequency * t));
  }
  return clip;
}

TEST(SoundMeasures, DecayOfOneModeIsThatOfItsRate) {
  // T60 = ln(1000) / d, from 0.07 s to one that the clip shows a tenth of.
  for (const double d : {100.0, 20.0, 5.0, 0.7}) {
    const auto measured = sweep::measure_sound(ring(1000, d, 0.3), 44100);
    ASSERT_TRUE(measured && measured->decay_s) << d;
    EXPECT_NEAR(*measured->decay_s * d / std::log(1000.0), 1, 0.02) << d;
  }
}

TEST(SoundMeasures, LevelPeakAndCentroidOfASine) {
  const auto sine = sweep::measure_sound(ring(1000, 0, 0.5), 44100);
  ASSERT_TRUE(sine);
  EXPECT_NEAR(sine->level_db, 20 * std::log10(0.5 / std::sqrt(2.0)), 1e-3);
  EXPECT_NEAR(sine->peak_db, 20 * std::log10(0.5), 1e-2);
  EXPECT_NEAR(sine->centroid_hz, 1000, 1);
}

TEST(SoundMeasures, WhatDoesNotDecayHasNoDecayTime) {
  EXPECT_FALSE(sweep::measure_sound(ring(1000, -3, 1e-3), 44100)->decay_s);
  EXPECT_FALSE(sweep::measure_sound(std::vector<float>(44100, 0.0F), 44100));
  EXPECT_FALSE(sweep::measure_sound({}, 44100));
}

}  // namespace
}  // namespace carillon::dataset
