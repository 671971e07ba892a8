// A recorder's band limits, its codec, and where its clips stop.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "synth/recording/band_limits.hpp"
#include "synth/recording/codec.hpp"
#include "synth/recording/recording_chain.hpp"

namespace carillon::synth {
namespace {

constexpr double rate = 44100;

/// Magnitude of a filter at a frequency, by its response to one sample.
template <class Filter>
double magnitude(const Filter& filter, double edge, double frequency) {
  std::vector<float> response(8192, 0.0F);
  response[0] = 1;
  filter(response, edge, rate);
  double real = 0, imaginary = 0;
  for (std::size_t n = 0; n < response.size(); ++n) {
    const double angle = 2 * std::numbers::pi * frequency * static_cast<double>(n) / rate;
    real += response[n] * std::cos(angle);
    imaginary -= response[n] * std::sin(angle);
  }
  return std::hypot(real, imaginary);
}

/// Frequency against an edge as the bilinear transform bends it.
double warped_ratio(double frequency, double edge) {
  return std::tan(std::numbers::pi * frequency / rate) / std::tan(std::numbers::pi * edge / rate);
}

TEST(BandLimits, AreButterworths) {
  for (const double edge : {200.0, 3000.0, 15000.0}) {
    for (const double factor : {0.1, 0.5, 1.0, 1.3}) {
      const double x = warped_ratio(factor * edge, edge);
      EXPECT_NEAR(magnitude(recording::cut_above, edge, factor * edge),
                  1 / std::sqrt(1 + std::pow(x, 8)), 1e-5);
      EXPECT_NEAR(magnitude(recording::cut_below, edge, factor * edge),
                  1 / std::sqrt(1 + std::pow(x, -4)), 1e-5);
    }
  }
  std::vector<float> clip(10);
  for (const double edge : {0.0, -1.0, rate / 2, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(recording::cut_above(clip, edge, rate), core::InputError);
    EXPECT_THROW(recording::cut_below(clip, edge, rate), core::InputError);
  }
}

std::vector<float> strike(double sample_rate) {
  std::vector<float> clip(static_cast<std::size_t>(sample_rate), 0.0F);
  for (std::size_t n = 2000; n < clip.size(); ++n) {
    const double t = static_cast<double>(n - 2000) / sample_rate;
    clip[n] = static_cast<float>(0.4 * std::exp(-20 * t) * std::sin(6283 * t) +
                                 0.2 * std::exp(-40 * t) * std::sin(21700 * t));
  }
  return clip;
}

/// Power of the difference where the other is `lag` samples later, against the first one's.
double difference(const std::vector<float>& one, const std::vector<float>& other, int lag) {
  double apart = 0, power = 0;
  for (int n = 2000; n < 12000; ++n) {
    const auto at = static_cast<std::size_t>(n), later = static_cast<std::size_t>(n + lag);
    apart += std::pow(double{other[later]} - one[at], 2);
    power += std::pow(double{one[at]}, 2);
  }
  return apart / power;
}

TEST(Codecs, KeepTimeAndTakeQuality) {
  for (const double sample_rate : {44100.0, 32000.0, 31214.0}) {
    const std::vector<float> clip = strike(sample_rate);
    for (const recording::Codec codec :
         {recording::Codec::mp3, recording::Codec::vorbis, recording::Codec::opus}) {
      const std::string& name = recording::codec_names()[static_cast<std::size_t>(codec)];
      std::vector<float> fine = clip, coarse = clip;
      recording::pass_through(codec, 0.1, fine, sample_rate);
      recording::pass_through(codec, 0.8, coarse, sample_rate);
      EXPECT_LT(difference(clip, fine, 0), 1e-3) << name << " " << sample_rate;
      EXPECT_GT(difference(clip, coarse, 0), 1.5 * difference(clip, fine, 0)) << name;
      for (const int lag : {-3, -2, -1, 1, 2, 3}) {
        EXPECT_GT(difference(clip, fine, lag), difference(clip, fine, 0)) << name << " " << lag;
      }
      std::vector<float> again = clip;
      recording::pass_through(codec, 0.8, again, sample_rate);
      EXPECT_EQ(again, coarse) << name;
    }
  }
}

TEST(Codecs, LeaveSilenceAndRefuseWhatIsNoSound) {
  std::vector<float> silence(44100, 0.0F), clip = strike(rate), none = clip;
  recording::pass_through(recording::Codec::mp3, 0.5, silence, rate);
  for (const float sample : silence) EXPECT_LT(std::abs(sample), 1e-4F);
  recording::pass_through(recording::Codec::none, 0.5, none, rate);
  EXPECT_EQ(none, clip);
  EXPECT_THROW(recording::pass_through(recording::Codec::mp3, 1, clip, rate), core::InputError);
  clip[7] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(recording::pass_through(recording::Codec::mp3, 0.5, clip, rate), core::InputError);
}

TEST(StopAt, FadesAndIsSilentFromThereOn) {
  std::vector<float> clip(1000, 1.0F);
  recording::stop_at(clip, 600, 200);
  EXPECT_EQ(clip[400], 1);
  EXPECT_NEAR(clip[500], 0.5, 1e-6);
  EXPECT_EQ(*std::max_element(clip.begin() + 600, clip.end()), 0);
  EXPECT_TRUE(std::is_sorted(clip.rbegin(), clip.rend()));
  std::vector<float> whole(10, 1.0F);
  recording::stop_at(whole, 300, 200);
  EXPECT_EQ(whole, std::vector<float>(10, 1.0F));
}

}  // namespace
}  // namespace carillon::synth
