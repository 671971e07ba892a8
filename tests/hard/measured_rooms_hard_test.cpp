// Measured responses that are not what they should be.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "../synth/sound_files.hpp"
#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "synth/room/measured_responses.hpp"

namespace carillon::synth {
namespace {

std::vector<double> pulse_at(std::size_t place, std::size_t count = 4410) {
  std::vector<double> samples(count, 0.0);
  samples[place] = 1;
  return samples;
}

/// What is said of a folder that holds a good response and something else.
std::string refusal(const core::TemporaryFolder& folder,
                    const room::MeasuredOptions& options = {}) {
  write_sound(folder / "good.wav", pulse_at(10), 44100);
  try {
    const room::MeasuredResponses responses(folder.path(), options);
  } catch (const core::InputError& error) {
    EXPECT_FALSE(error.hint().empty());
    EXPECT_EQ(error.message().find("good.wav"), std::string::npos) << error.message();
    return error.message();
  }
  return "";
}

void expect_refused(const core::TemporaryFolder& folder, const std::string& file,
                    const std::string& reason, const room::MeasuredOptions& options = {}) {
  const std::string said = refusal(folder, options);
  EXPECT_NE(said.find(file + ": "), std::string::npos) << said;
  EXPECT_NE(said.find(reason), std::string::npos) << said;
}

TEST(HardMeasuredRooms, SilenceIsRefused) {
  const core::TemporaryFolder folder;
  write_sound(folder / "silent.wav", std::vector<double>(4410, 0.0), 44100);
  expect_refused(folder, "silent.wav", "silent: no sample is other than 0");
}

TEST(HardMeasuredRooms, AnEmptyFileIsRefused) {
  const core::TemporaryFolder folder;
  write_sound(folder / "empty.wav", {}, 44100);
  expect_refused(folder, "empty.wav", "no samples");
}

TEST(HardMeasuredRooms, NumbersThatAreNoneAreRefused) {
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const core::TemporaryFolder folder;
    auto samples = pulse_at(10);
    samples[1234] = wrong;
    write_sound(folder / "wrong.wav", samples, 44100);
    expect_refused(folder, "wrong.wav", "sample 1234 is not a finite number");
  }
}

TEST(HardMeasuredRooms, WhatIsNoSoundIsRefused) {
  const core::TemporaryFolder folder;
  std::ofstream(folder / "readme.txt") << "Measured in 2019.";
  std::ofstream(folder / ".hidden") << "passed over";
  const std::string said = refusal(folder);
  EXPECT_NE(said.find("1 of 2 files"), std::string::npos) << said;
  EXPECT_NE(said.find("readme.txt: "), std::string::npos) << said;
}

TEST(HardMeasuredRooms, ManyWrongFilesAreNamedAndCounted) {
  const core::TemporaryFolder folder;
  for (int k = 0; k < 30; ++k) {
    write_sound(folder / fmt::format("{:02}.wav", k), std::vector<double>(441, 0.0), 44100 + k);
  }
  const std::string said = refusal(folder);
  EXPECT_NE(said.find("30 of 31 files"), std::string::npos) << said;
  EXPECT_NE(said.find("and 10 more"), std::string::npos) << said;
}

// Reversed, or with a click where the recording was stopped.
TEST(HardMeasuredRooms, OneThatIsLoudestAtItsEndIsRefused) {
  const core::TemporaryFolder folder;
  std::vector<double> reversed = some_noise(4410, 3);
  for (std::size_t i = 0; i < reversed.size(); ++i) {
    reversed[i] *= std::exp((static_cast<double>(i) - 4410) / 400);
  }
  reversed.back() = 1;
  write_sound(folder / "reversed.wav", reversed, 44100);
  expect_refused(folder, "reversed.wav", "loudest at its end, 0.09998 of 0.1 s");
}

TEST(HardMeasuredRooms, OneSampleIsAPulse) {
  for (const int rate : {8000, 44100, 192000}) {
    for (const double clips : {8000.0, 44100.0, 96000.0}) {
      room::MeasuredOptions options;
      options.sample_rate = clips;
      const core::TemporaryFolder folder;
      write_sound(folder / "one.wav", {-0.2}, rate);
      const room::MeasuredResponses responses(folder.path(), options);
      const std::vector<float>& samples = responses.all()[0].samples;
      ASSERT_FALSE(samples.empty());
      double energy = 0;
      for (const float value : samples) energy += static_cast<double>(value) * value;
      EXPECT_NEAR(energy, 1, 0.01) << rate << " at " << clips;
    }
  }
}

TEST(HardMeasuredRooms, AMinuteInAClipOfASampleIsOneSample) {
  room::MeasuredOptions options;
  options.count = 1;
  for (const double rate : {44100.0, 8000.0}) {
    const auto samples = room::from_direct_sound(some_noise(60 * 8000, 1), rate, options);
    ASSERT_EQ(samples.size(), 1u);
    EXPECT_FLOAT_EQ(std::abs(samples[0]), 1);
  }
}

// A response of ultrasound alone: nothing of it is left in clips of 8 kHz.
TEST(HardMeasuredRooms, WhatLiesAboveTheClipsIsRefused) {
  const core::TemporaryFolder folder;
  std::vector<double> samples = sine(9600, 30000, 96000);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] *= 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i) / 9600);
  }
  write_sound(folder / "high.wav", samples, 96000);
  room::MeasuredOptions options;
  options.sample_rate = 8000;
  expect_refused(folder, "high.wav", "nothing of it is below 4000 Hz", options);
}

TEST(HardMeasuredRooms, LevelsOfAnySizeComeOutAlike) {
  for (const double level : {1e-30, 1e-6, 1e6, 1e30}) {
    auto samples = pulse_at(100);
    samples[200] = -0.5;
    for (double& value : samples) value *= level;
    const auto made = room::from_direct_sound(samples, 44100, {});
    EXPECT_FLOAT_EQ(made[100] / made[0], -0.5F) << level;
    EXPECT_NEAR(made[0], std::sqrt(1 / 1.25), 1e-6) << level;
  }
}

TEST(HardMeasuredRooms, FewerFilesThanPartsAreRefused) {
  const core::TemporaryFolder folder;
  room::MeasuredOptions options;
  options.parts = 9;
  write_sound(folder / "one.wav", pulse_at(5), 44100);
  try {
    const room::MeasuredResponses responses(folder.path(), options);
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("1 response for 9 parts"), std::string::npos);
    EXPECT_NE(error.hint().find("one file"), std::string::npos);
  }
  // Copies are none.
  for (int k = 0; k < 9; ++k) {
    std::filesystem::copy(folder / "one.wav", folder / fmt::format("copy{}.wav", k));
  }
  EXPECT_THROW(room::MeasuredResponses(folder.path(), options), core::InputError);
}

TEST(HardMeasuredRooms, AnEmptyFolderIsRefused) {
  const core::TemporaryFolder folder;
  EXPECT_THROW(room::MeasuredResponses(folder.path(), {}), core::InputError);
  EXPECT_THROW(room::MeasuredResponses(folder / "absent", {}), core::InputError);
}

TEST(HardMeasuredRooms, AChannelThatIsNotThereIsRefused) {
  const core::TemporaryFolder folder;
  write_sound(folder / "good.wav", {1, 0, 0, 0, 0, 0.5}, 44100, 2);
  room::MeasuredOptions options;
  options.channel = 3;
  try {
    const room::MeasuredResponses responses(folder.path(), options);
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("no channel 3: it has 2"), std::string::npos);
  }
}

}  // namespace
}  // namespace carillon::synth
