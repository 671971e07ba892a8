#include "eval/features/detail/reverberation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "eval/features/extract_features.hpp"
#include "tests/eval/strike_clip.hpp"

namespace carillon::eval {
namespace {

TEST(Reverberation, ReverberantOnesAreMarked) {
  TestRandom random(6);
  const std::vector<Partial> partials = {{500, 5, 1, 0}, {1500, 20, 1, 1}, {4000, 60, 1, 2}};
  const ClipShape shape{44100, 1, 0};
  std::vector<double> samples = strike_clip(partials, shape);
  add_noise(samples, shape, 60, random);
  features::FeatureOptions options;
  options.rt60 = {0.5};  // 13.8 1/s
  const features::FeatureSet set = features::extract_features(samples, shape.sample_rate, options);
  ASSERT_EQ(set.features.size(), 3u);
  EXPECT_FALSE(set.features[0].reverberant);
  EXPECT_TRUE(set.features[1].reverberant);
  EXPECT_TRUE(set.features[2].reverberant);
}

TEST(Reverberation, TheRoomsOwnDecaysAreMarked) {
  const std::vector<Partial> slow = {{640, 2, 0.5, 1}, {1250, 4, 0.7, 2}, {2470, 7, 1, 3}};
  std::vector<Partial> partials = {{3900, 40, 1, 0}, {5200, 60, 1, 1}, {6500, 90, 1, 2}};
  partials.insert(partials.end(), slow.begin(), slow.end());
  const ClipShape shape{44100, 1, 0};
  features::FeatureOptions options;
  options.max_features = 60;
  std::size_t false_ones = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    TestRandom random(seed);
    std::vector<double> samples = strike_in_room(partials, shape, 0.3, random);
    add_noise(samples, shape, 40, random);
    options.rt60 = {0.3};  // 23 1/s
    const features::FeatureSet set =
        features::extract_features(samples, shape.sample_rate, options);
    std::size_t found = 0, marked = 0;
    for (const features::Feature& feature : set.features) {
      if (feature.reverberant) {
        ++marked;
        continue;
      }
      const auto near = std::min_element(slow.begin(), slow.end(), [&](auto& a, auto& b) {
        return std::abs(a.frequency - feature.frequency) <
               std::abs(b.frequency - feature.frequency);
      });
      const bool true_one = std::abs(near->frequency - feature.frequency) < 0.1 &&
                            std::abs(feature.decay_rate / near->decay_rate - 1) < 0.05;
      ++(true_one ? found : false_ones);
    }
    EXPECT_EQ(found, slow.size()) << seed;
    EXPECT_GT(marked, 10u) << seed;
  }
  EXPECT_LE(false_ones, 1u);
}

/// Octaves that do not reverberate have no room's decays to tell modes from.
TEST(Reverberation, ARoomWithoutReverberationChangesNothing) {
  TestRandom random(8);
  const std::vector<Partial> partials = {{250, 4, 1, 0},  {600, 6, 0.8, 1},  {1400, 5, 0.9, 2},
                                         {3100, 7, 1, 3}, {6500, 8, 0.7, 4}, {11000, 6, 0.9, 5}};
  const ClipShape shape{44100, 1, 0};
  std::vector<double> samples = strike_clip(partials, shape);
  add_noise(samples, shape, 60, random);
  features::FeatureOptions dry, partly;
  dry.rt60 = {0, 0};
  partly.rt60 = {0.2, 0.2, 0.2, 0};
  EXPECT_EQ(features::extract_features(samples, shape.sample_rate, dry).features.size(),
            partials.size());
  const features::FeatureSet set = features::extract_features(samples, shape.sample_rate, partly);
  EXPECT_EQ(set.features.size(), partials.size());
  for (const features::Feature& feature : set.features) EXPECT_FALSE(feature.reverberant);
}

/// A clip that ends before the room does shows no mode for sure, and says so.
TEST(Reverberation, ShortClipsInRoomsAreNotTrusted) {
  const std::vector<Partial> slow = {{640, 2, 0.5, 1}, {2470, 7, 1, 3}};
  const ClipShape shape{44100, 0.25, 0};
  features::FeatureOptions options;
  options.rt60 = {0.5};
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    TestRandom random(seed);
    std::vector<double> samples = strike_in_room(slow, shape, 0.5, random);
    add_noise(samples, shape, 70, random);
    const features::FeatureSet set =
        features::extract_features(samples, shape.sample_rate, options);
    EXPECT_FALSE(set.features.empty());
    for (const features::Feature& feature : set.features) EXPECT_TRUE(feature.reverberant);
    ASSERT_FALSE(set.remarks.empty());
    EXPECT_NE(set.remarks.back().find("too short to tell modes from the room"), std::string::npos);
  }
}

/// What is not relied on need not be looked for.
TEST(Reverberation, OnlyModesThatOutlastTheRoom) {
  const std::vector<Partial> partials = {{640, 2, 0.5, 1}, {2470, 7, 1, 3}, {5200, 60, 1, 1}};
  const ClipShape shape{44100, 1, 0};
  TestRandom random(3);
  std::vector<double> samples = strike_in_room(partials, shape, 0.3, random);
  add_noise(samples, shape, 40, random);
  features::FeatureOptions options;
  options.rt60 = {0.3};
  const features::FeatureSet all = features::extract_features(samples, shape.sample_rate, options);
  options.keep_reverberant = false;
  const features::FeatureSet modes =
      features::extract_features(samples, shape.sample_rate, options);
  std::vector<double> reliable, alone;
  for (const features::Feature& f : all.features) {
    if (!f.reverberant) reliable.push_back(f.decay_rate);
  }
  for (const features::Feature& f : modes.features) alone.push_back(f.decay_rate);
  EXPECT_EQ(reliable, alone);
  EXPECT_EQ(alone.size(), 2u);
  EXPECT_NEAR(modes.begin, 0.1, 1e-3);
}

/// A blip long after the onset has an amplitude at the onset that no number can hold.
TEST(Reverberation, WhatIsGoneAtOnceHidesNothing) {
  features::Feature mode, blip;
  mode.frequency = blip.frequency = 1000;
  mode.decay_rate = 2;
  mode.amplitude = 0.5;
  mode.snr = 70;
  blip.decay_rate = 1900;
  blip.amplitude = std::exp(blip.decay_rate * 0.4);
  ASSERT_TRUE(std::isinf(blip.amplitude));
  const std::vector<features::Feature> found = {mode, blip};
  const std::vector<double> rt60 = {1.2};
  const auto modes = features::outlasting(found, {0.4, 3}, rt60);
  ASSERT_EQ(modes.size(), 1u);
  EXPECT_EQ(modes[0].decay_rate, mode.decay_rate);
}

}  // namespace
}  // namespace carillon::eval
