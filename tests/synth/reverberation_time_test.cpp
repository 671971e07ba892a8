#include "synth/room/detail/reverberation_time.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::synth {
namespace {

std::vector<double> exponential(double rt60, double sample_rate, std::size_t count) {
  std::vector<double> decay(count);
  for (std::size_t n = 0; n < count; ++n) {
    decay[n] = std::pow(10, -3 * static_cast<double>(n) / (sample_rate * rt60));
  }
  return decay;
}

RC_GTEST_PROP(ReverberationTime, IsExactForExponentialDecays, ()) {
  const double rt60 = *rc::gen::inRange(20, 3000) / 1000.0;
  // Cut at 60 to 200 dB, where nothing but the cut ends the decay.
  const auto count = static_cast<std::size_t>(rt60 * 8000 * *rc::gen::inRange(60, 200) / 60.0);
  const auto found = room::reverberation_time(exponential(rt60, 8000, count), 8000);
  RC_ASSERT(found.has_value());
  RC_ASSERT(std::abs(found->rt60 / rt60 - 1) < 1e-6);
  RC_ASSERT(std::abs(found->correlation + 1) < 1e-9);
}

TEST(ReverberationTime, HasNoScale) {
  const auto decay = exponential(0.5, 8000, 6000);
  for (const double scale : {1e-200, 1e-12, 1e12, 1e200}) {
    auto scaled = decay;
    for (double& v : scaled) v *= -scale;
    EXPECT_NEAR(room::reverberation_time(scaled, 8000)->rt60, 0.5, 1e-6) << scale;
  }
}

TEST(ReverberationTime, ADecayIntoNoiseIsCutThere) {
  core::RandomStream random(1, 2, "test");
  std::vector<double> decay = exponential(0.5, 44100, 44100);
  for (double& v : decay) v = v * random.normal() + 1e-3 * random.normal();  // -60 dB
  const auto found = room::reverberation_time(decay, 44100);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->rt60, 0.5, 0.015);
  // Noise only 40 dB down: there is a T20, and no T30.
  for (double& v : decay) v += 0.01 * random.normal();
  EXPECT_FALSE(room::reverberation_time(decay, 44100, 30).has_value());
  const auto t20 = room::reverberation_time(decay, 44100, 20);
  ASSERT_TRUE(t20.has_value());
  EXPECT_NEAR(t20->rt60, 0.5, 0.03);
}

TEST(ReverberationTime, NoiseHasNone) {
  core::RandomStream random(1, 2, "test");
  std::vector<double> noise(10000);
  for (double& v : noise) v = random.normal();
  EXPECT_FALSE(room::reverberation_time(noise, 8000).has_value());
  EXPECT_FALSE(room::reverberation_time(std::vector<double>{1.0}, 8000).has_value());
}

TEST(ReverberationTime, RefusesSilenceAndNumbersThatAreNone) {
  EXPECT_THROW(room::reverberation_time(std::vector<double>(100, 0.0), 8000), core::InputError);
  EXPECT_THROW(room::reverberation_time(std::vector<double>{}, 8000), core::InputError);
  EXPECT_THROW(room::reverberation_time(std::vector<double>{1, std::nan(""), 0}, 8000),
               core::InputError);
  EXPECT_THROW(room::reverberation_time(std::vector<double>{1, 0.5}, 0), core::InputError);
  EXPECT_THROW(room::reverberation_time(std::vector<double>{1, 0.5}, 8000, -3), core::InputError);
}

TEST(OctaveBand, PassesItsMiddleWithoutDelayAndNothingOutside) {
  const double rate = 44100;
  const auto gain = [rate](double frequency, double centre) {
    std::vector<double> tone(44100);
    for (std::size_t n = 0; n < tone.size(); ++n) {
      tone[n] = std::sin(2 * M_PI * frequency * static_cast<double>(n) / rate);
    }
    const auto filtered = room::octave_band(tone, rate, centre);
    double along = 0, energy = 0;
    for (std::size_t n = 11025; n < 33075; ++n) {
      along += filtered[n] * tone[n];
      energy += tone[n] * tone[n];
    }
    return along / energy;  // in phase
  };
  EXPECT_NEAR(gain(1000, 1000), 1, 1e-3);
  EXPECT_NEAR(gain(1250, 1000), 1, 1e-3);
  EXPECT_NEAR(gain(1500, 1000), 0, 1e-3);
  EXPECT_NEAR(gain(690, 1000), 0, 1e-3);
  EXPECT_THROW(room::octave_band(std::vector<double>(10, 1.0), 16000, 16000), core::InputError);
}

}  // namespace
}  // namespace carillon::synth
