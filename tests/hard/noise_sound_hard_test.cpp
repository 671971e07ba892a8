// Recordings that are not what they should be, and clips without a signal-to-noise ratio.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "../synth/sound_files.hpp"
#include "../synth/welch.hpp"
#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "synth/recording/noise_generators.hpp"
#include "synth/recording/noise_recordings.hpp"
#include "synth/recording/recording_chain.hpp"
#include "synth/recording/signal_to_noise.hpp"

namespace carillon::synth {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// A good recording beside the bad one, and what is said of that.
std::string reason_for(const core::TemporaryFolder& folder, const std::string& name) {
  write_sound(folder / "good.wav", some_noise(22050, 99), 44100);
  recording::NoiseFolder noise(folder.path(), {});
  EXPECT_EQ(noise.recordings().size(), 1u);
  EXPECT_EQ(noise.left_out().size(), 1u);
  core::RandomStream random(1, 2, "hard.noise");
  const recording::NoiseDraw drawn = noise.draw(44100, 0, 1, random);
  for (const recording::NoiseSegment& segment : drawn.segments) EXPECT_EQ(segment.name, "good.wav");
  const std::string said = noise.left_out().empty() ? "" : noise.left_out().front();
  EXPECT_TRUE(said.starts_with(name + ": ")) << said;
  return said.substr(std::min(said.size(), name.size() + 2));
}

/// A tone of 1 kHz in a file, drawn at 44.1 kHz: it must be there, and alone.
void expect_tone(const std::filesystem::path& folder, double noise_floor, int channel = 0) {
  recording::NoiseFolder noise(folder, {.channel = channel});
  ASSERT_EQ(noise.recordings().size(), 1u) << noise.left_out().front();
  core::RandomStream random(1, 3, "hard.noise");
  const auto samples = noise.draw(8192, 0, 1, random).samples;
  const double level = tone_level(samples, 1000, 44100);
  // Root mean square 1, of which a coarse format's own noise has a fraction.
  EXPECT_NEAR(level, 10 * std::log10(2.0), noise_floor < -40 ? 0.05 : 0.2);
  double rest = 0;
  for (const double other : {517.0, 1490.0, 2003.0, 3100.0}) {
    rest = std::max(rest, std::pow(10.0, (tone_level(samples, other, 44100) - level) / 20));
  }
  EXPECT_LT(20 * std::log10(rest), noise_floor);
}

TEST(HardNoise, ASilentFileIsLeftOut) {
  const core::TemporaryFolder folder;
  write_sound(folder / "silent.wav", std::vector<double>(44100, 0.0), 44100);
  EXPECT_EQ(reason_for(folder, "silent.wav"),
            "silent (nothing above -100 dB of full scale in the mean of its channels)");
}

TEST(HardNoise, AnAlmostSilentFileIsLeftOut) {
  const core::TemporaryFolder folder;
  auto samples = some_noise(44100, 1);
  for (double& sample : samples) sample *= 1e-6;
  write_sound(folder / "faint.wav", samples, 44100);
  EXPECT_NE(reason_for(folder, "faint.wav").find("silent"), std::string::npos);
}

TEST(HardNoise, ChannelsThatCancelAreSilentInTheMeanButNotAlone) {
  const core::TemporaryFolder folder;
  std::vector<double> samples;
  for (const double sample : sine(44100, 1000, 44100)) {
    samples.push_back(sample);
    samples.push_back(-sample);
  }
  write_sound(folder / "stereo.wav", samples, 44100, 2);
  EXPECT_THROW(recording::NoiseFolder(folder.path(), {}), core::InputError);
  expect_tone(folder.path(), -100, 2);
}

TEST(HardNoise, AFileShorterThanAMillisecondIsLeftOut) {
  const core::TemporaryFolder folder;
  write_sound(folder / "short.wav", some_noise(44, 1), 44100);
  EXPECT_EQ(reason_for(folder, "short.wav"), "44 samples, shorter than 1 ms");
}

TEST(HardNoise, AFileWithoutSamplesIsLeftOut) {
  const core::TemporaryFolder folder;
  write_sound(folder / "none.wav", {}, 44100);
  EXPECT_EQ(reason_for(folder, "none.wav"), "0 samples, shorter than 1 ms");
}

TEST(HardNoise, NaNAndInfinityAreLeftOut) {
  for (const double bad : {std::nan(""), infinity, -infinity}) {
    const core::TemporaryFolder folder;
    auto samples = some_noise(44100, 1);
    samples[30000] = bad;
    write_sound(folder / "bad.wav", samples, 44100);
    EXPECT_EQ(reason_for(folder, "bad.wav"), "sample 30000 is not a finite number");
  }
}

TEST(HardNoise, UnreadableFilesAreLeftOut) {
  const core::TemporaryFolder folder;
  std::ofstream(folder / "text.wav") << "no sound at all";
  EXPECT_NE(reason_for(folder, "text.wav").find("cannot be read: "), std::string::npos);
}

TEST(HardNoise, AFileCutShortGivesWhatIsThere) {
  const core::TemporaryFolder folder;
  write_sound(folder / "cut.wav", some_noise(44100, 1), 44100);
  std::filesystem::resize_file(folder / "cut.wav", 44 + 4 * 22050);
  recording::NoiseFolder noise(folder.path(), {});
  EXPECT_NEAR(noise.recordings().at(0).audible_seconds, 0.5, 0.01);
}

TEST(HardNoise, TheSameSoundTwiceCountsOnce) {
  const core::TemporaryFolder folder;
  write_sound(folder / "copy.flac", sine(44100, 440, 44100), 44100, 1,
              SF_FORMAT_FLAC | SF_FORMAT_PCM_16);
  write_sound(folder / "good.wav", some_noise(44100, 99), 44100);
  write_sound(folder / "original.wav", sine(44100, 440, 44100), 44100, 1,
              SF_FORMAT_WAV | SF_FORMAT_PCM_16);
  const recording::NoiseFolder noise(folder.path(), {});
  ASSERT_EQ(noise.left_out().size(), 1u);
  EXPECT_EQ(noise.left_out()[0], "original.wav: the same as copy.flac");
}

TEST(HardNoise, EveryFormatGivesItsTone) {
  struct Case {
    const char* name;
    int format;
    double floor;  ///< [dB] of what the format itself adds
  };
  const Case cases[] = {
      {"pcm8.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_U8, -45},
      {"pcm16.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_16, -95},
      {"pcm24.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_24, -120},
      {"pcm32.wav", SF_FORMAT_WAV | SF_FORMAT_PCM_32, -120},
      {"float32.wav", SF_FORMAT_WAV | SF_FORMAT_FLOAT, -120},
      {"float64.wav", SF_FORMAT_WAV | SF_FORMAT_DOUBLE, -120},
      {"ms_adpcm.wav", SF_FORMAT_WAV | SF_FORMAT_MS_ADPCM, -30},
      {"ima_adpcm.wav", SF_FORMAT_WAV | SF_FORMAT_IMA_ADPCM, -30},
      {"mu_law.wav", SF_FORMAT_WAV | SF_FORMAT_ULAW, -30},
      {"flac.flac", SF_FORMAT_FLAC | SF_FORMAT_PCM_24, -120},
      {"vorbis.ogg", SF_FORMAT_OGG | SF_FORMAT_VORBIS, -30},
      {"pcm16.aiff", SF_FORMAT_AIFF | SF_FORMAT_PCM_16, -95},
  };
  for (const Case& one : cases) {
    SCOPED_TRACE(one.name);
    const core::TemporaryFolder folder;
    write_sound(folder / one.name, sine(44100, 1000, 44100), 44100, 1, one.format);
    expect_tone(folder.path(), one.floor);
  }
}

TEST(HardNoise, EveryRateGivesItsTone) {
  for (const int rate : {8000, 11025, 16000, 22050, 32000, 44100, 48000, 88200, 96000, 192000}) {
    SCOPED_TRACE(rate);
    const core::TemporaryFolder folder;
    write_sound(folder / "tone.wav", sine(std::size_t(rate), 1000, rate), rate);
    // The cut at the ends rings a little; the window of the measurement takes most of it away.
    expect_tone(folder.path(), -80);
  }
}

TEST(HardNoise, RatesThatAreNoSoundAreLeftOut) {
  for (const int rate : {1, 999, 1'000'001}) {
    const core::TemporaryFolder folder;
    write_sound(folder / "odd.wav", some_noise(44100, 1), rate);
    EXPECT_NE(reason_for(folder, "odd.wav").find("not between 1 kHz and 1 MHz"), std::string::npos);
  }
}

TEST(HardNoise, StereoIsTheMeanOrAChannel) {
  const core::TemporaryFolder folder;
  std::vector<double> samples;
  const auto left = sine(44100, 1000, 44100), right = some_noise(44100, 1);
  for (std::size_t i = 0; i < left.size(); ++i) {
    samples.push_back(left[i]);
    samples.push_back(right[i]);
  }
  write_sound(folder / "stereo.wav", samples, 44100, 2);
  expect_tone(folder.path(), -100, 1);
  EXPECT_EQ(recording::NoiseFolder(folder.path(), {}).recordings().size(), 1u);
  try {
    recording::NoiseFolder(folder.path(), {.channel = 3});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("stereo.wav: no channel 3: it has 2"), std::string::npos);
  }
}

TEST(HardNoise, LevelsOfAnySizeGiveTheSameNoise) {
  std::vector<double> first;
  for (const double level : {1e-3, 1.0, 1e30}) {
    const core::TemporaryFolder folder;
    auto samples = some_noise(22050, 1);
    for (double& sample : samples) sample *= level;
    write_sound(folder / "a.wav", samples, 22050);
    recording::NoiseFolder noise(folder.path(), {});
    core::RandomStream random(1, 3, "hard.noise");
    const auto drawn = noise.draw(1000, 0, 1, random).samples;
    if (first.empty()) first = drawn;
    for (std::size_t i = 0; i < drawn.size(); ++i) ASSERT_NEAR(drawn[i], first[i], 1e-5) << level;
  }
}

TEST(HardNoise, SilentStretchesAreNeverDrawn) {
  // 93 % of the file is digital silence around three short sounds.
  const core::TemporaryFolder folder;
  std::vector<double> samples(5 * 44100, 0.0);
  const auto sound = some_noise(5000, 1);
  for (const std::size_t at : {1000U, 100'000U, 190'000U}) {
    std::copy(sound.begin(), sound.end(), samples.begin() + at);
  }
  write_sound(folder / "bursts.wav", samples, 44100);
  recording::NoiseFolder noise(folder.path(), {});
  EXPECT_NEAR(noise.recordings()[0].audible_seconds, 3 * 5000 / 44100.0, 0.05);
  for (std::uint64_t item = 0; item < 50; ++item) {
    core::RandomStream random(1, item, "hard.noise");
    const auto drawn = noise.draw(44100, 0, 1, random).samples;
    for (std::size_t i = 0; i + 4410 <= drawn.size(); i += 441) {
      double sum = 0;
      for (std::size_t k = i; k < i + 4410; ++k) sum += drawn[k] * drawn[k];
      ASSERT_GT(sum / 4410, 0.1);
    }
  }
}

TEST(HardNoise, AFolderWithoutUsableFilesSaysWhatIsWrongWithEach) {
  const core::TemporaryFolder folder;
  write_sound(folder / "silent.wav", std::vector<double>(44100, 0.0), 44100);
  write_sound(folder / "short.wav", some_noise(10, 1), 44100);
  std::ofstream(folder / "notes.txt") << "recorded on Sunday";
  std::ofstream(folder / ".hidden") << "not looked at";
  try {
    recording::NoiseFolder(folder.path(), {});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("none of 3 files can be used as noise:\n  notes.txt: "),
              std::string::npos)
        << error.message();
    EXPECT_NE(error.message().find("\n  short.wav: 10 samples"), std::string::npos);
    EXPECT_NE(error.message().find("\n  silent.wav: silent"), std::string::npos);
  }
}

TEST(HardNoise, AnEmptyOrAbsentFolderIsAnError) {
  const core::TemporaryFolder folder;
  try {
    recording::NoiseFolder(folder.path(), {});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("the folder has no files"), std::string::npos);
  }
  try {
    recording::NoiseFolder(folder / "absent", {});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(error.message().find("absent: the folder cannot be read: No such file"),
              std::string::npos);
  }
}

TEST(HardNoise, TooLittleSoundForAllPartsIsAnError) {
  const core::TemporaryFolder folder;
  write_sound(folder / "a.wav", some_noise(22050, 1), 44100);
  recording::NoiseFolder noise(folder.path(), {});
  core::RandomStream random(1, 2, "hard.noise");
  EXPECT_EQ(noise.draw(1000, 4, 5, random).samples.size(), 1000u);
  // Whatever part is asked for, so that all ranks fail alike.
  for (const std::size_t part : {0U, 5U}) {
    try {
      noise.draw(1000, part, 6, random);
      FAIL();
    } catch (const core::InputError& error) {
      EXPECT_NE(error.message().find("1 recordings leave 0.083"), std::string::npos)
          << error.message();
      EXPECT_EQ(error.hint(), "add recordings, or longer ones");
    }
  }
}

TEST(HardNoise, AFileThatChangesDuringABuildIsAnError) {
  const core::TemporaryFolder folder;
  write_sound(folder / "a.wav", some_noise(22050, 1), 44100);
  recording::NoiseFolder noise(folder.path(), {});
  write_sound(folder / "a.wav", some_noise(22050, 2), 44100);
  core::RandomStream random(1, 2, "hard.noise");
  EXPECT_THROW(noise.draw(1000, 0, 1, random), core::InputError);
}

TEST(HardNoise, ClipsOfAnyLengthAndLevelTakeNoise) {
  for (const std::size_t count : {1U, 2U, 17U, 44100U}) {
    for (const float level : {1e-30F, 1e-12F, 1.0F, 1e12F, 1e30F}) {
      std::vector<float> clip(count, 0.0F);
      clip[count / 2] = level;
      const auto clean = clip;
      const auto part = recording::active_part(clip, 1, 44100);
      core::RandomStream random(1, count, "hard.noise");
      const auto noise =
          recording::generate_noise(recording::NoiseKind::white, count, 44100, random);
      recording::add_noise(clip, noise, 1, part, 20);
      const double rest = double(clip[count / 2]) - clean[count / 2];
      EXPECT_NEAR(20 * std::log10(std::abs(level / rest)), 20, 1e-3) << count << " " << level;
      for (const float sample : clip) EXPECT_TRUE(std::isfinite(sample));
    }
  }
}

TEST(HardNoise, ASilentClipHasNoRatio) {
  std::vector<float> clip(1000, 0.0F);
  const auto part = recording::active_part(clip, 1, 44100);
  EXPECT_TRUE(part.empty());
  EXPECT_THROW(recording::add_noise(clip, some_noise(1000, 1), 1, part, 20), core::InputError);
  EXPECT_EQ(clip, std::vector<float>(1000, 0.0F));
}

TEST(HardNoise, AnInt16ClipThatRoundsToNothingIsTold) {
  std::vector<float> clip(1000, 1e-5F);
  EXPECT_TRUE(recording::silent_after_rounding(clip, 16));
  EXPECT_FALSE(recording::silent_after_rounding(clip, 24));
  // Dither carries what is below a step.
  core::RandomStream random(1, 2, "hard.dither");
  recording::quantise(clip, 16, &random);
  EXPECT_FALSE(recording::silent_after_rounding(clip, 16));
}

}  // namespace
}  // namespace carillon::synth
