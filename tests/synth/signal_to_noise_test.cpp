#include "synth/recording/signal_to_noise.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "sound_files.hpp"

namespace carillon::synth {
namespace {

/// Decay of a tone with rate d [1/s] that begins at `onset`.
std::vector<float> decay(std::size_t count, std::size_t onset, double d, double rate) {
  std::vector<float> clip(count, 0.0F);
  for (std::size_t i = onset; i < count; ++i) {
    const double t = static_cast<double>(i - onset) / rate;
    clip[i] = static_cast<float>(std::exp(-d * t) * std::cos(2 * 3.141592653589793 * 3000 * t));
  }
  return clip;
}

TEST(ActivePart, OfADecayIsItsT60) {
  for (const double d : {20.0, 60.0, 300.0}) {
    const auto part = recording::active_part(decay(44100, 2000, d, 44100), 1, 44100);
    EXPECT_EQ(part.begin, 2000u);
    // ln(1000)/d; the tone's own swing within 10 ms moves the end by less than a millisecond.
    EXPECT_NEAR(static_cast<double>(part.size()) / 44100, std::log(1000.0) / d, 1e-3) << d;
  }
}

TEST(ActivePart, ReachesTheEndOfWhatDoesNotDecay) {
  std::vector<float> clip(1000, 0.5F);
  auto part = recording::active_part(clip, 1, 44100);
  EXPECT_EQ(part.begin, 0u);
  EXPECT_EQ(part.end, 1000u);
  clip.assign(1, -2.0F);
  part = recording::active_part(clip, 1, 44100);
  EXPECT_EQ(part.size(), 1u);
}

TEST(ActivePart, OfAClickIsTheClick) {
  std::vector<float> clip(5000, 0.0F);
  clip[100] = 1e-30F;
  const auto part = recording::active_part(clip, 1, 44100);
  EXPECT_EQ(part.begin, 100u);
  EXPECT_EQ(part.end, 101u);
}

TEST(ActivePart, OfSeveralRowsIsWhereAnyOfThemSounds) {
  auto clip = decay(1000, 10, 2000, 44100);
  const auto late = decay(1000, 500, 2000, 44100);
  clip.insert(clip.end(), late.begin(), late.end());
  const auto part = recording::active_part(clip, 2, 44100);
  EXPECT_EQ(part.begin, 10u);
  EXPECT_GT(part.end, 500u);
}

TEST(ActivePart, IsThatOfSumsWrittenOut) {
  EXPECT_TRUE(rc::check([] {
    const auto count = *rc::gen::inRange<std::size_t>(1, 200);
    const auto window = *rc::gen::inRange<std::size_t>(1, 60);
    std::vector<float> clip(count);
    for (float& sample : clip) {
      sample = std::pow(10.0F, -static_cast<float>(*rc::gen::inRange(0, 60)) / 10);
    }
    double highest = 0;
    std::vector<double> sums(count, 0.0);
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t k = i; k < std::min(count, i + window); ++k) {
        sums[i] += double(clip[k]) * clip[k];
      }
      highest = std::max(highest, sums[i]);
    }
    std::size_t end = count;
    while (sums[end - 1] < 1e-6 * highest) --end;
    const auto part = recording::active_part(clip, 1, 100.0 * double(window));
    RC_ASSERT(part.end == std::max(end, part.begin + 1));
  }));
}

TEST(ActivePart, OfSilenceIsEmpty) {
  EXPECT_TRUE(recording::active_part(std::vector<float>(100, 0.0F), 1, 44100).empty());
  EXPECT_TRUE(recording::active_part({}, 1, 44100).empty());
}

TEST(ActivePart, RefusesWhatIsNotFinite) {
  std::vector<float> clip(10, 0.1F);
  clip[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(recording::active_part(clip, 1, 44100), core::InputError);
  clip[3] = 0;
  EXPECT_THROW(recording::active_part(clip, 3, 44100), core::InputError);
  EXPECT_THROW(recording::active_part(clip, 0, 44100), core::InputError);
  EXPECT_THROW(recording::active_part(clip, 1, 0), core::InputError);
}

/// By the smallest means: the sums written out.
double measured(const std::vector<float>& clean, const std::vector<float>& noisy, std::size_t begin,
                std::size_t end) {
  long double signal = 0, noise = 0;
  for (std::size_t i = begin; i < end; ++i) {
    signal += static_cast<long double>(clean[i]) * clean[i];
    const long double rest = static_cast<long double>(noisy[i]) - clean[i];
    noise += rest * rest;
  }
  return static_cast<double>(10 * std::log10(signal / noise));
}

TEST(AddNoise, GivesTheRatioThatWasAskedFor) {
  EXPECT_TRUE(rc::check([] {
    const double decibels = *rc::gen::inRange(-600, 600) * 0.1;
    const double d = *rc::gen::inRange(15, 500);
    const auto onset = *rc::gen::inRange<std::size_t>(0, 4000);
    const auto clean = decay(9000, onset, d, 44100);
    auto noisy = clean;
    const auto part = recording::active_part(clean, 1, 44100);
    const auto noise = some_noise(clean.size(), *rc::gen::arbitrary<unsigned>());
    const double factor = recording::add_noise(noisy, noise, 1, part, decibels);
    // What single precision leaves of noise 60 dB below.
    RC_ASSERT(std::abs(measured(clean, noisy, part.begin, part.end) - decibels) < 1e-3);
    for (std::size_t i = 0; i < clean.size(); ++i) {
      RC_ASSERT(noisy[i] == static_cast<float>(clean[i] + factor * noise[i]));
    }
  }));
}

TEST(AddNoise, IsOverTheActivePartAndNotOverTheWholeClip) {
  // A second of silence after a sound of 0.1 s must not make the noise 10 dB weaker.
  const auto clean = decay(44100, 0, 70, 44100);
  auto noisy = clean;
  const auto part = recording::active_part(clean, 1, 44100);
  recording::add_noise(noisy, some_noise(44100, 1), 1, part, 10);
  EXPECT_NEAR(measured(clean, noisy, part.begin, part.end), 10, 1e-4);
  EXPECT_LT(measured(clean, noisy, 0, 44100), 1);
}

TEST(AddNoise, KeepsTheLevelsOfRows) {
  auto clip = decay(2000, 0, 100, 44100);
  for (std::size_t i = 0; i < 2000; ++i) clip.push_back(0.1F * clip[i]);
  const auto clean = clip;
  const auto part = recording::active_part(clip, 2, 44100);
  recording::add_noise(clip, some_noise(4000, 5), 2, part, 20);
  long double signal = 0, noise = 0;
  for (std::size_t row = 0; row < 2; ++row) {
    for (std::size_t i = part.begin; i < part.end; ++i) {
      const std::size_t at = row * 2000 + i;
      signal += static_cast<long double>(clean[at]) * clean[at];
      noise += std::pow(static_cast<long double>(clip[at]) - clean[at], 2);
    }
  }
  EXPECT_NEAR(static_cast<double>(10 * std::log10(signal / noise)), 20, 1e-4);
}

TEST(AddNoise, RefusesWhatHasNoRatio) {
  std::vector<float> clip(100, 0.5F);
  const recording::ActivePart all{0, 100};
  const std::vector<double> noise = some_noise(100, 1);
  std::vector<double> late(100, 0.0);
  late[99] = 1;
  EXPECT_THROW(recording::add_noise(clip, std::vector<double>(100, 0.0), 1, all, 10),
               core::InputError);
  EXPECT_THROW(recording::add_noise(clip, late, 1, {0, 50}, 10), core::InputError);
  EXPECT_THROW(recording::add_noise(clip, noise, 1, {}, 10), core::InputError);
  EXPECT_THROW(recording::add_noise(clip, some_noise(99, 1), 1, all, 10), core::InputError);
  EXPECT_THROW(recording::add_noise(clip, noise, 1, {0, 101}, 10), core::InputError);
  EXPECT_THROW(recording::add_noise(clip, noise, 1, all, -800), core::InputError);
  EXPECT_EQ(clip, std::vector<float>(100, 0.5F));
  std::vector<float> silent(100, 0.0F);
  EXPECT_THROW(recording::add_noise(silent, noise, 1, all, 10), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
