#include "eval/features/segment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "eval/features/detail/damage.hpp"
#include "eval/features/detail/strikes.hpp"
#include "eval/features/extract_features.hpp"
#include "tests/eval/strike_clip.hpp"

namespace carillon::eval {
namespace {

const std::vector<Partial> bar = {
    {611.3, 7, 0.3, 0.4}, {1530.2, 12, 0.25, 1.1}, {3122.9, 25, 0.2, -2}, {5210.4, 45, 0.12, 2.5}};
constexpr double rate = 22050;

struct Hit {
  double time = 0;
  double level = 1;
};

/// Several strikes of one object in noise at -74 dB of full scale.
std::vector<double> struck(std::span<const Hit> hits, double seconds = 0.9) {
  TestRandom random(4);
  std::vector<double> samples(static_cast<std::size_t>(seconds * rate));
  for (double& sample : samples) sample = 2e-4 * random.normal();
  for (const Hit& hit : hits) {
    const auto one = strike_clip(bar, {rate, seconds, hit.time});
    for (std::size_t n = 0; n < samples.size(); ++n) samples[n] += hit.level * one[n];
  }
  return samples;
}

features::Segment segment_of(std::span<const double> samples, std::optional<double> onset = {}) {
  return features::find_segment(samples, rate, onset, 0.003);
}

double seconds(std::size_t sample) {
  return static_cast<double>(sample) / rate;
}

std::string all_remarks(const features::Segment& segment) {
  std::string all;
  for (const std::string& remark : segment.remarks) all += remark + "\n";
  return all;
}

TEST(Segments, BeginAtTheOnset) {
  TestRandom random(2);
  const Partial partial{700, 30, 0.5, 0.3};
  for (const double onset : {0.0, 0.0131, 0.25}) {
    const ClipShape shape{44100, 0.8, onset};
    std::vector<double> samples = strike_clip({&partial, 1}, shape);
    for (double& sample : samples) sample += 5e-4 * random.normal();
    const features::Segment segment = features::find_segment(samples, shape.sample_rate, {}, 0.003);
    EXPECT_NEAR(static_cast<double>(segment.onset) / shape.sample_rate, onset, 5e-4) << onset;
    EXPECT_EQ(segment.begin, segment.onset + 132);
    EXPECT_EQ(segment.end, samples.size());
  }
}

// Two modes 7 Hz apart beat, which is no second strike.
TEST(Segments, DoNotEndAtABeat) {
  for (const double apart : {1.0, 3.0, 7.0, 15.0, 40.0}) {
    const std::vector<Partial> pair = {{900, 3, 1, 0}, {900 + apart, 3, 1, 0}};
    const ClipShape shape{44100, 1.5, 0.01};
    const auto samples = strike_clip(pair, shape);
    EXPECT_EQ(features::find_segment(samples, shape.sample_rate, {}, 0.003).end, samples.size())
        << apart;
  }
}

// Free decay of two modes is predicted by four coefficients, whatever their amplitudes.
TEST(PredictionError, VanishesForDampedSinusoids) {
  const std::vector<Partial> two = {{900, 20, 1, 0.3}, {2300, 35, 0.7, 1}};
  const auto samples = strike_clip(two, {rate, 0.5, 0});
  const auto filter = features::prediction_error_filter(samples, 32);
  double error = 0, power = 0;
  for (std::size_t n = filter.size(); n < samples.size(); ++n) {
    double sum = 0;
    for (std::size_t j = 0; j < filter.size(); ++j) sum += filter[j] * samples[n - j];
    error += sum * sum;
    power += samples[n] * samples[n];
  }
  EXPECT_EQ(filter[0], 1);
  EXPECT_LT(error, 1e-6 * power);
  // Noise is not predicted: one that is white keeps its power.
  TestRandom random(1);
  std::vector<double> noise(20000);
  for (double& sample : noise) sample = random.normal();
  for (const double coefficient : features::prediction_error_filter(noise, 8)) {
    EXPECT_LT(std::abs(coefficient), coefficient == 1 ? 1.1 : 0.03);
  }
}

TEST(ChangeOfPower, IsFoundToTheSample) {
  TestRandom random(8);
  for (const std::size_t change : {40u, 200u, 700u}) {
    std::vector<double> samples(1000);
    for (std::size_t n = 0; n < samples.size(); ++n) {
      samples[n] = (n < change ? 0.1 : 1.0) * random.normal();
    }
    EXPECT_NEAR(static_cast<double>(features::change_of_power(samples)),
                static_cast<double>(change), 3);
  }
  const std::vector<double> few(5, 1.0);
  EXPECT_EQ(features::change_of_power(few), 0u);
}

// From 5 ms on, equal or of half the level.
TEST(Segments, TellTwoStrikesApart) {
  for (const double apart : {0.005, 0.008, 0.012, 0.025, 0.045, 0.08}) {
    for (const double level : {1.0, 0.5}) {
      const std::vector<Hit> hits = {{0.02, 1}, {0.02 + apart, level}};
      const auto samples = struck(hits);
      const auto strikes = features::find_strikes(samples, rate);
      ASSERT_EQ(strikes.size(), 2u) << apart << " s, level " << level;
      EXPECT_NEAR(seconds(strikes[0]), hits[0].time, 2e-4);
      EXPECT_NEAR(seconds(strikes[1]), hits[1].time, 2e-4) << apart;
      // After the last one both ring freely.
      const features::Segment segment = segment_of(samples);
      EXPECT_NEAR(seconds(segment.onset), hits[1].time, 2e-4) << apart;
      EXPECT_EQ(segment.end, samples.size());
      EXPECT_FALSE(segment.remarks.empty());
    }
  }
}

TEST(Segments, TakeTheLoudestStrike) {
  // A precursor is passed over, and said.
  features::Segment segment = segment_of(struck(std::vector<Hit>{{0.02, 0.3}, {0.06, 1}}));
  EXPECT_NEAR(seconds(segment.onset), 0.06, 2e-4);
  EXPECT_NE(all_remarks(segment).find("struck before, at 0.020 s"), std::string::npos);
  EXPECT_NEAR(seconds(segment.quiet), 0.02, 2e-4);
  // What follows much later is left out.
  segment = segment_of(struck(std::vector<Hit>{{0.02, 1}, {0.3, 0.7}}));
  EXPECT_NEAR(seconds(segment.onset), 0.02, 2e-4);
  EXPECT_NEAR(seconds(segment.end), 0.3, 2e-3);
  EXPECT_NE(all_remarks(segment).find("another strike or lost samples at 0.300 s"),
            std::string::npos);
}

TEST(Segments, TakeTheStrikeThatIsNamed) {
  const auto samples = struck(std::vector<Hit>{{0.02, 1}, {0.3, 0.7}, {0.6, 1}});
  for (const double label : {0.3, 0.285, 0.302}) {
    const features::Segment segment = segment_of(samples, label);
    EXPECT_NEAR(seconds(segment.onset), label, 1e-4);
    EXPECT_NEAR(seconds(segment.begin), std::max(label, 0.3) + 0.003, 3e-4) << label;
    EXPECT_NEAR(seconds(segment.end), 0.6, 2e-3) << label;
  }
}

TEST(Segments, BeginInAStrike) {
  const auto samples = struck(std::vector<Hit>{{0.02, 1}});
  for (const double cut : {0.02, 0.021, 0.03}) {
    const auto rest = std::span(samples).subspan(static_cast<std::size_t>(cut * rate));
    const features::Segment segment = segment_of(rest);
    EXPECT_TRUE(segment.nothing.empty());
    EXPECT_LT(seconds(segment.onset), 2e-3) << cut;
    EXPECT_EQ(segment.end, rest.size());
  }
}

// The noise of the lead-in is within 5 to 17 dB of the sound's first 0.1 s.
TEST(Segments, FindOnsetsInNoise) {
  int right = 0, all = 0;
  for (const double snr : {5.0, 11.0, 17.0}) {
    for (std::uint64_t seed = 1; seed <= 9; ++seed) {
      TestRandom random(seed);
      std::vector<Partial> partials;
      for (int k = 0; k < 8; ++k) {
        partials.push_back({random.uniform(300, 6000), random.uniform(5, 40),
                            random.uniform(0.3, 1), random.uniform(0, 2 * std::numbers::pi)});
      }
      const ClipShape shape{44100, 1, 0.2};
      std::vector<double> samples = strike_clip(partials, shape);
      add_noise(samples, shape, snr, random);
      const features::Segment segment = features::find_segment(samples, 44100, {}, 0.003);
      right += std::abs(static_cast<double>(segment.onset) / 44100 - 0.2) < 0.002;
      ++all;
    }
  }
  EXPECT_GE(right, all - 1);
}

// Clipped, then played at another rate: the tops are no longer equal.
TEST(Segments, BeginAfterTopsThatWereLimited) {
  std::vector<double> samples = struck(std::vector<Hit>{{0.02, 1}});
  double peak = 0;
  for (const double sample : samples) peak = std::max(peak, std::abs(sample));
  for (double& sample : samples) sample = std::clamp(sample, -0.65 * peak, 0.65 * peak);
  // A filter of a few samples, as converters of rates have.
  std::vector<double> blurred(samples.size());
  for (std::size_t n = 2; n + 2 < samples.size(); ++n) {
    blurred[n] = -0.03 * (samples[n - 2] + samples[n + 2]) +
                 0.1 * (samples[n - 1] + samples[n + 1]) + 0.86 * samples[n];
  }
  const features::FeatureSet set = features::extract_features(blurred, rate);
  ASSERT_FALSE(set.remarks.empty());
  EXPECT_NE(set.remarks.front().find("tops are limited"), std::string::npos) << set.remarks.front();
  EXPECT_GT(set.begin, set.onset + 0.02);
  ASSERT_EQ(set.features.size(), bar.size());
  for (std::size_t k = 0; k < bar.size(); ++k) {
    EXPECT_NEAR(set.features[k].decay_rate / bar[k].decay_rate, 1, 0.02);
  }
}

TEST(LimitedUntil, SaysNothingOfSoundsThatAreFree) {
  // A fork, two that beat, and sums of modes.
  for (std::size_t count = 1; count <= 20; ++count) {
    TestRandom random(count);
    std::vector<Partial> partials;
    for (std::size_t k = 0; k < count; ++k) {
      partials.push_back({count == 2 ? 440 + 4 * static_cast<double>(k) : random.uniform(200, 6000),
                          std::pow(10, random.uniform(-1, 1.3)), random.uniform(0.1, 1),
                          random.uniform(0, 6.28)});
    }
    const std::vector<double> samples = strike_clip(partials, {rate, 1, 0});
    EXPECT_FALSE(features::limited_until(samples, 0, samples.size())) << count;
  }
  // Hum of mains, which does not decay.
  const std::vector<Partial> hums = {{50, 0, 1, 0.3}, {100, 0, 0.7, 1}};
  const std::vector<double> samples = strike_clip(hums, {rate, 1, 0});
  EXPECT_FALSE(features::limited_until(samples, 0, samples.size()));
}

TEST(Segments, EndWhereSamplesAreMissing) {
  std::vector<double> samples = struck(std::vector<Hit>{{0.02, 1}});
  const auto from = static_cast<std::size_t>(0.2 * rate);
  std::fill(samples.begin() + static_cast<std::ptrdiff_t>(from),
            samples.begin() + static_cast<std::ptrdiff_t>(from + 100), 0.0);
  features::Segment segment = segment_of(samples);
  EXPECT_NEAR(seconds(segment.end), 0.2, 2e-3);
  EXPECT_FALSE(segment.remarks.empty());
  // Silence that is appended is no loss.
  samples = struck(std::vector<Hit>{{0.02, 1}}, 1.5);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    samples[n] =
        std::round(samples[n] * 32768 * std::min(1.0, std::exp(6 - 8 * seconds(n)))) / 32768;
  }
  segment = segment_of(samples);
  EXPECT_EQ(all_remarks(segment), "");
}

// Samples that were lost leave a step in a sound that rings on.
TEST(Segments, EndWhereSamplesWereLost) {
  std::vector<double> samples = struck(std::vector<Hit>{{0.02, 1}});
  const auto place = static_cast<std::ptrdiff_t>(0.3 * rate);
  samples.erase(samples.begin() + place, samples.begin() + place + 37);
  const features::Segment segment = segment_of(samples);
  EXPECT_NEAR(seconds(segment.end), 0.3, 2e-3);
  EXPECT_NE(all_remarks(segment).find("lost samples at 0.300 s"), std::string::npos);
}

}  // namespace
}  // namespace carillon::eval
