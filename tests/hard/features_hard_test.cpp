// Recordings that break feature extraction: docs/hard-cases.md says what each must come to.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "eval/features/extract_features.hpp"
#include "tests/eval/strike_clip.hpp"

namespace carillon::eval {
namespace {

constexpr double contact = 0.003;
constexpr double within = 5;  ///< Cramer-Rao bounds
const std::vector<Partial> three = {{523, 8, 1, 0.3}, {1480, 15, 0.7, 1}, {3950, 60, 0.8, 2}};

const features::Feature* nearest(const features::FeatureSet& set, double frequency) {
  const features::Feature* best = nullptr;
  for (const features::Feature& feature : set.features) {
    if (!best || std::abs(feature.frequency - frequency) < std::abs(best->frequency - frequency)) {
      best = &feature;
    }
  }
  return best;
}

bool remarks_on(const features::FeatureSet& set, const std::string& part) {
  return std::any_of(set.remarks.begin(), set.remarks.end(), [&](const std::string& remark) {
    return remark.find(part) != std::string::npos;
  });
}

std::vector<double> with_noise(std::span<const Partial> partials, const ClipShape& shape,
                               double snr_db, std::uint64_t seed, double* deviation = nullptr) {
  TestRandom random(seed);
  std::vector<double> samples = strike_clip(partials, shape);
  const double noise = add_noise(samples, shape, snr_db, random);
  if (deviation) *deviation = noise;
  return samples;
}

/// Every partial is there, exact to a few bounds, and nothing else is.
void expect_exact(const features::FeatureSet& set, std::span<const Partial> partials,
                  const ClipShape& shape, double noise) {
  EXPECT_EQ(set.nothing, "");
  ASSERT_EQ(set.features.size(), partials.size());
  const std::vector<Bound> bounds = cramer_rao(partials, shape, contact, noise);
  for (std::size_t i = 0; i < partials.size(); ++i) {
    const features::Feature* feature = nearest(set, partials[i].frequency);
    EXPECT_NEAR(feature->frequency, partials[i].frequency, within * bounds[i].frequency);
    EXPECT_NEAR(feature->decay_rate, partials[i].decay_rate, within * bounds[i].decay_rate)
        << partials[i].frequency << " Hz";
  }
}

void expect_decay_rates(const features::FeatureSet& set, std::span<const Partial> partials,
                        double tolerance) {
  ASSERT_EQ(set.features.size(), partials.size());
  for (const Partial& partial : partials) {
    const features::Feature* feature = nearest(set, partial.frequency);
    EXPECT_NEAR(feature->frequency, partial.frequency, 0.5);
    EXPECT_NEAR(feature->decay_rate / partial.decay_rate, 1, tolerance) << partial.frequency;
  }
}

void expect_nothing(const features::FeatureSet& set, const std::string& reason) {
  EXPECT_TRUE(set.features.empty());
  EXPECT_EQ(set.nothing, reason);
}

TEST(FeaturesHard, Silence) {
  expect_nothing(features::extract_features(std::vector<double>(44100, 0.0), 44100), "silent");
  expect_nothing(features::extract_features(std::vector<double>(44100, 1e-9), 44100), "silent");
}

TEST(FeaturesHard, Constant) {
  expect_nothing(features::extract_features(std::vector<double>(44100, 0.25), 44100),
                 "constant: nothing moves");
  // Beneath a strike it changes nothing.
  const ClipShape shape{44100, 1, 0.05};
  double noise = 0;
  std::vector<double> samples = with_noise(three, shape, 60, 1, &noise);
  for (double& sample : samples) sample += 0.25;
  expect_exact(features::extract_features(samples, 44100), three, shape, noise);
}

TEST(FeaturesHard, ClippedAtHalfThePeak) {
  const ClipShape shape{44100, 1, 0.05};
  std::vector<double> samples = with_noise(three, shape, 60, 2);
  double peak = 0;
  for (const double sample : samples) peak = std::max(peak, std::abs(sample));
  for (double& sample : samples) sample = std::clamp(sample, -0.5 * peak, 0.5 * peak);
  const features::FeatureSet set = features::extract_features(samples, 44100);
  EXPECT_GT(set.clipped, 20u);
  EXPECT_GT(set.begin, set.onset + contact);
  EXPECT_TRUE(remarks_on(set, "samples are clipped: left out up to"));
  const auto begin = samples.begin() + std::lround(set.begin * 44100);
  EXPECT_EQ(std::count_if(begin, samples.end(),
                          [&](double sample) { return std::abs(sample) == 0.5 * peak; }),
            0);
  expect_decay_rates(set, three, 0.02);
}

TEST(FeaturesHard, NoNumbers) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()}) {
    std::vector<double> samples = strike_clip(three, {44100, 1, 0});
    samples[22050] = bad;
    std::string message = "none";
    try {
      features::extract_features(samples, 44100);
    } catch (const core::InputError& error) {
      message = error.what();
    }
    EXPECT_NE(message.find("sample 22050 (at 0.5000 s) is "), std::string::npos) << message;
  }
}

TEST(FeaturesHard, TooShort) {
  expect_nothing(features::extract_features({}, 44100), "too short: 0 samples");
  expect_nothing(features::extract_features(std::vector<double>{0.5}, 44100),
                 "too short: 1 sample");
  const features::FeatureSet few =
      features::extract_features(strike_clip(three, {44100, 0.01, 0}), 44100);
  expect_nothing(few, "too short: 441 samples");
  // Long enough, but for the part after the strike.
  const features::FeatureSet late =
      features::extract_features(strike_clip(three, {44100, 0.5, 0.49}), 44100);
  EXPECT_TRUE(late.features.empty());
  EXPECT_EQ(late.nothing.rfind("too short: ", 0), 0u) << late.nothing;
  EXPECT_NE(late.nothing.find("ms after the strike"), std::string::npos) << late.nothing;
}

TEST(FeaturesHard, EightKilohertz) {
  const std::vector<Partial> partials = {{320, 6, 1, 0}, {1450, 20, 0.8, 1}, {3700, 40, 0.6, 2}};
  const ClipShape shape{8000, 1, 0.05};
  double noise = 0;
  const std::vector<double> samples = with_noise(partials, shape, 60, 3, &noise);
  expect_exact(features::extract_features(samples, 8000), partials, shape, noise);
}

TEST(FeaturesHard, OneHundredAndNinetyTwoKilohertz) {
  const std::vector<Partial> partials = {
      {320, 6, 1, 0}, {14500, 60, 0.8, 1}, {55000, 120, 0.6, 2}, {90000, 200, 0.6, 1}};
  const ClipShape shape{192000, 0.5, 0.02};
  double noise = 0;
  const std::vector<double> samples = with_noise(partials, shape, 60, 4, &noise);
  features::FeatureOptions options;
  options.max_frequency = 1e6;
  expect_exact(features::extract_features(samples, 192000, options), partials, shape, noise);
  // By default nothing above hearing.
  expect_exact(features::extract_features(samples, 192000), {partials.data(), 2}, shape, noise);
}

TEST(FeaturesHard, TonesNearHalfTheRate) {
  for (const double rate : {8000., 44100., 192000.}) {
    const std::vector<Partial> partials = {{0.05 * rate, 6, 1, 0}, {0.3 * rate, 20, 0.8, 1}};
    std::vector<Partial> all = partials;
    all.push_back({0.484 * rate, 10, 0.5, 1});
    const std::vector<double> samples = with_noise(all, {rate, 0.5, 0.02}, 60, 4);
    features::FeatureOptions options;
    options.max_frequency = 1e6;
    const features::FeatureSet set = features::extract_features(samples, rate, options);
    ASSERT_EQ(set.features.size(), partials.size());
    for (const Partial& partial : partials) {
      const features::Feature* feature = nearest(set, partial.frequency);
      EXPECT_NEAR(feature->frequency / partial.frequency, 1, 5e-6);
      EXPECT_NEAR(feature->decay_rate / partial.decay_rate, 1, 2e-3);
    }
  }
}

TEST(FeaturesHard, TwoImpacts) {
  const ClipShape shape{44100, 1.5, 0.05};
  std::vector<double> samples = with_noise(three, shape, 60, 5);
  const std::vector<double> again = strike_clip(three, {44100, 1.5, 0.6});
  for (std::size_t n = 0; n < samples.size(); ++n) samples[n] += 0.8 * again[n];
  const features::FeatureSet set = features::extract_features(samples, 44100);
  EXPECT_NEAR(set.onset, 0.05, 1e-3);
  EXPECT_NEAR(set.end, 0.6, 0.01);
  EXPECT_LE(set.end, 0.6);
  EXPECT_TRUE(remarks_on(set, "another strike or lost samples at 0.600 s"));
  expect_decay_rates(set, three, 0.01);
}

TEST(FeaturesHard, OnsetAtTheFirstSample) {
  const ClipShape shape{44100, 1, 0};
  double noise = 0;
  const std::vector<double> samples = with_noise(three, shape, 60, 6, &noise);
  const features::FeatureSet set = features::extract_features(samples, 44100);
  EXPECT_NEAR(set.onset, 0, 1e-3);
  expect_exact(set, three, shape, noise);
}

TEST(FeaturesHard, HumAlone) {
  TestRandom random(7);
  std::vector<double> samples(44100);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const double t = static_cast<double>(n) / 44100;
    samples[n] = 0.3 * std::sin(2 * std::numbers::pi * 50 * t) +
                 0.1 * std::sin(2 * std::numbers::pi * 100 * t + 1) + 1e-4 * random.normal();
  }
  const features::FeatureSet set = features::extract_features(samples, 44100);
  expect_nothing(set, "only steady tones");
  ASSERT_EQ(set.hums.size(), 2u);
  EXPECT_NEAR(set.hums[0].frequency, 50, 0.01);
  EXPECT_NEAR(set.hums[1].frequency, 100, 0.01);
  EXPECT_NEAR(set.hums[0].amplitude, 0.3, 0.01);
}

TEST(FeaturesHard, NoiseAlone) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    TestRandom random(seed);
    std::vector<double> samples(22050);
    for (double& sample : samples) sample = 0.1 * random.normal();
    expect_nothing(features::extract_features(samples, 22050), "no decaying tone above the noise");
  }
}

TEST(FeaturesHard, AlreadyRinging) {
  // Cut 0.1 s after the strike: what rings is all there is.
  std::vector<Partial> partials = {{523, 8, 1, 0.3}, {1480, 15, 0.7, 1}, {3950, 30, 0.8, 2}};
  const ClipShape whole{44100, 1.1, 0};
  double noise = 0;
  const std::vector<double> samples = with_noise(partials, whole, 60, 8, &noise);
  const features::FeatureSet set =
      features::extract_features(std::span(samples).subspan(4410), 44100);
  EXPECT_NEAR(set.onset, 0, 1e-3);
  for (Partial& partial : partials) {
    partial.amplitude *= std::exp(-0.1 * partial.decay_rate);
    partial.phase += 2 * std::numbers::pi * 0.1 * partial.frequency;
  }
  expect_exact(set, partials, {44100, 1, 0}, noise);
  for (const Partial& partial : partials) {
    EXPECT_NEAR(nearest(set, partial.frequency)->amplitude / partial.amplitude, 1, 0.02);
  }
}

TEST(FeaturesHard, TwentyStepsOfInt16) {
  const ClipShape shape{44100, 1, 0.05};
  std::vector<double> samples = strike_clip(three, shape);
  double peak = 0;
  for (const double sample : samples) peak = std::max(peak, std::abs(sample));
  std::vector<Partial> partials = three;
  for (Partial& partial : partials) partial.amplitude *= 20 / peak;
  // Rounding with triangular dither is white noise of half a step.
  TestRandom random(11);
  for (double& sample : samples) {
    const double dither = random.uniform() - random.uniform();
    sample = std::round(20 * sample / peak + dither) / 32768;
  }
  expect_exact(features::extract_features(samples, 44100), partials, shape, 0.5);
}

TEST(FeaturesHard, VeryFastDecaysBesideSlowOnes) {
  const std::vector<Partial> slow = {{700, 4, 0.5, 0.3}, {2600, 9, 0.5, 1}};
  std::vector<Partial> all = slow;
  all.push_back({1500, 1500, 1, 0});
  all.push_back({5000, 1500, 1, 1});
  all.push_back({100, 1500, 1, 1});  // over within a sixth of a period
  const ClipShape shape{44100, 1, 0.05};
  double noise = 0;
  const std::vector<double> samples = with_noise(all, shape, 60, 9, &noise);
  // All that is left of them after contact is 60 dB below the slow ones.
  expect_exact(features::extract_features(samples, 44100), slow, shape, noise);
  // Analysed earlier, those of more than a period are heard.
  features::FeatureOptions options;
  options.contact_time = 0.001;
  const features::FeatureSet early = features::extract_features(samples, 44100, options);
  ASSERT_EQ(early.features.size(), 4u);
  for (const double frequency : {1500., 5000.}) {
    const features::Feature* feature = nearest(early, frequency);
    EXPECT_NEAR(feature->frequency, frequency, 15);  // of lines 480 Hz wide
    EXPECT_NEAR(feature->decay_rate / 1500, 1, 0.02);
  }
  for (const Partial& partial : slow) {
    EXPECT_NEAR(nearest(early, partial.frequency)->decay_rate / partial.decay_rate, 1, 1e-3);
  }
}

TEST(FeaturesHard, NotDecayedAtTheEnd) {
  const std::vector<Partial> partials = {{440, 1, 1, 0.3}, {1480, 2, 0.7, 1}, {3950, 3, 0.8, 2}};
  const ClipShape shape{44100, 0.35, 0.05};
  double noise = 0;
  const std::vector<double> samples = with_noise(partials, shape, 60, 10, &noise);
  const features::FeatureSet set = features::extract_features(samples, 44100);
  expect_exact(set, partials, shape, noise);
  EXPECT_TRUE(set.hums.empty());
}

TEST(FeaturesHard, WithoutAnyNoise) {
  const features::FeatureSet set =
      features::extract_features(strike_clip(three, {44100, 1, 0.05}), 44100);
  EXPECT_TRUE(set.hums.empty());
  ASSERT_EQ(set.features.size(), three.size());
  for (const Partial& partial : three) {
    const features::Feature* feature = nearest(set, partial.frequency);
    EXPECT_NEAR(feature->frequency / partial.frequency, 1, 1e-7);
    EXPECT_NEAR(feature->decay_rate / partial.decay_rate, 1, 1e-5);
    EXPECT_NEAR(feature->amplitude / partial.amplitude, 1, 1e-4);
  }
}

}  // namespace
}  // namespace carillon::eval
