#include "synth/recording/noise_recordings.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "sound_files.hpp"
#include "synth/recording/recording_file.hpp"
#include "synth/signal/cross_fade.hpp"
#include "welch.hpp"

namespace carillon::synth {
namespace {

core::RandomStream stream(std::uint64_t item) {
  return {5, item, "test.recordings"};
}

recording::NoiseDraw draw(recording::NoiseFolder& folder, std::size_t count, std::uint64_t item,
                          std::size_t part = 0, std::size_t parts = 1) {
  auto random = stream(item);
  return folder.draw(count, part, parts, random);
}

double power(std::span<const double> samples) {
  double sum = 0;
  for (const double sample : samples) sum += sample * sample;
  return sum / static_cast<double>(samples.size());
}

TEST(CrossFade, KeepsThePowerOfIndependentNoises) {
  constexpr std::size_t overlap = 1000;
  std::vector<double> sum(3 * overlap, 0.0);
  for (unsigned item = 0; item < 400; ++item) {
    auto samples = some_noise(2 * overlap, 2 * item);
    const auto other = some_noise(2 * overlap, 2 * item + 1);
    signal::append_cross_faded(samples, std::vector<float>(other.begin(), other.end()), overlap);
    ASSERT_EQ(samples.size(), 3 * overlap);
    for (std::size_t i = 0; i < samples.size(); ++i) sum[i] += samples[i] * samples[i];
  }
  // Means over 100 samples of 400 noises: 0.03 dB of scatter; a dip of linear fades would be 3 dB.
  for (std::size_t i = 0; i < sum.size(); i += 100) {
    double mean = 0;
    for (std::size_t k = i; k < i + 100; ++k) mean += sum[k] / (100 * 400);
    EXPECT_NEAR(10 * std::log10(mean / 0.01), 0, 0.15) << i;
  }
}

TEST(CrossFade, LeavesNoClick) {
  // Two slow tones that meet at opposite extremes: put end to end they jump by 2.
  std::vector<double> samples(1000);
  std::vector<float> next(1000);
  for (std::size_t i = 0; i < 1000; ++i) {
    samples[i] = std::cos(0.01 * (double(i) - 999));
    next[i] = static_cast<float>(-std::cos(0.01 * double(i)));
  }
  signal::append_cross_faded(samples, next, 400);
  EXPECT_EQ(samples.size(), 1600u);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    // A tone's own slope 0.01, and twice the fade's pi / 2 / 400.
    EXPECT_LT(std::abs(samples[i] - samples[i - 1]), 0.02 + 2 * 0.004) << i;
  }
}

TEST(CrossFade, MayBeEmptyButNotTooLong) {
  std::vector<double> samples = {1, 2};
  signal::append_cross_faded(samples, std::vector<float>{3}, 0);
  EXPECT_EQ(samples, (std::vector<double>{1, 2, 3}));
  EXPECT_THROW(signal::append_cross_faded(samples, std::vector<float>{3}, 2), core::InputError);
  signal::append_cross_faded(samples, {}, 0);
  EXPECT_EQ(samples.size(), 3u);
}

TEST(AudibleRuns, LeaveOutSilentStretches) {
  std::vector<float> samples(10000, 0.0F);
  for (std::size_t i = 2000; i < 4000; ++i) samples[i] = 0.1F;
  for (std::size_t i = 4500; i < 5000; ++i) samples[i] = 0.1F;  // after 0.05 s
  for (std::size_t i = 8000; i < 8001; ++i) samples[i] = 0.1F;  // after 0.3 s
  const auto runs = recording::audible_runs(samples, 10000);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].begin, 2000u);
  EXPECT_EQ(runs[0].end, 5000u);
  EXPECT_EQ(runs[1].begin, 8000u);
  EXPECT_EQ(runs[1].end, 8100u);
  EXPECT_TRUE(recording::audible_runs(std::vector<float>(100, 9e-6F), 10000).empty());
  EXPECT_TRUE(recording::audible_runs({}, 10000).empty());
}

TEST(NoiseFolder, DrawsStretchesOfItsRecordings) {
  const core::TemporaryFolder folder;
  const auto recording = some_noise(44100, 1);
  write_sound(folder / "a.wav", recording, 44100);
  recording::NoiseFolder noise(folder.path(), {});
  const double rms = std::sqrt(power(recording));
  std::set<double> starts;
  for (std::uint64_t item = 0; item < 20; ++item) {
    const recording::NoiseDraw drawn = draw(noise, 5000, item);
    ASSERT_EQ(drawn.segments.size(), 1u);
    const auto start = static_cast<std::size_t>(std::lround(drawn.segments[0].start * 44100));
    starts.insert(drawn.segments[0].start);
    ASSERT_LE(start + 5000, recording.size());
    for (std::size_t i = 0; i < 5000; ++i) {
      ASSERT_NEAR(drawn.samples[i], recording[start + i] / rms, 1e-6);
    }
  }
  EXPECT_EQ(starts.size(), 20u);
}

TEST(NoiseFolder, JoinsShortRecordingsWithoutALoop) {
  const core::TemporaryFolder folder;
  write_sound(folder / "short.wav", some_noise(8000, 3), 16000);
  recording::NoiseFolder noise(folder.path(), {.sample_rate = 16000});
  const recording::NoiseDraw drawn = draw(noise, 64000, 1);
  ASSERT_EQ(drawn.samples.size(), 64000u);
  EXPECT_GE(drawn.segments.size(), 8u);
  std::set<double> durations;
  for (const recording::NoiseSegment& segment : drawn.segments) {
    durations.insert(segment.duration);
    EXPECT_GE(segment.start, 0);
    EXPECT_LE(segment.start + segment.duration, 0.5 + 1e-9);
  }
  EXPECT_EQ(durations.size(), drawn.segments.size());
  // A loop would repeat itself fully after one lag; stretches of other places and lengths do not.
  const double all = power(drawn.samples) * 64000;
  for (std::size_t lag = 3000; lag < 10000; ++lag) {
    double product = 0;
    for (std::size_t i = lag; i < 64000; ++i) product += drawn.samples[i] * drawn.samples[i - lag];
    ASSERT_LT(product / all, 0.5) << lag;
  }
  // Neither dips nor bursts where they are joined.
  for (std::size_t i = 0; i + 800 <= 64000; i += 100) {
    ASSERT_NEAR(10 * std::log10(power(std::span(drawn.samples).subspan(i, 800))), 0, 1.2) << i;
  }
}

TEST(NoiseFolder, BringsRecordingsToOneLevel) {
  const core::TemporaryFolder folder;
  auto loud = some_noise(20000, 1), quiet = some_noise(20000, 2);
  for (double& sample : quiet) sample *= 0.01;
  write_sound(folder / "loud.wav", loud, 44100);
  write_sound(folder / "quiet.wav", quiet, 44100);
  recording::NoiseFolder noise(folder.path(), {});
  std::set<std::string> names;
  for (std::uint64_t item = 0; item < 20; ++item) {
    const recording::NoiseDraw drawn = draw(noise, 10000, item);
    names.insert(drawn.segments[0].name);
    EXPECT_NEAR(10 * std::log10(power(drawn.samples)), 0, 0.2);
  }
  EXPECT_EQ(names, (std::set<std::string>{"loud.wav", "quiet.wav"}));
}

TEST(NoiseFolder, NeitherEarlierDrawsNorMemoryChangeADraw) {
  const core::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "sub");
  for (unsigned i = 0; i < 5; ++i) {
    write_sound(folder / (i % 2 ? "sub/" : "") / (std::to_string(i) + ".wav"),
                some_noise(3000 + 1000 * i, i), i % 2 ? 22050 : 48000);
  }
  recording::NoiseFolder ample(folder.path(), {});
  std::vector<std::vector<double>> expected;
  for (std::uint64_t item = 0; item < 10; ++item) {
    expected.push_back(draw(ample, 20000, item, item % 3, 3).samples);
  }
  recording::NoiseFolder narrow(folder.path(), {.memory = 0});
  for (std::uint64_t item = 10; item-- > 0;) {
    draw(narrow, 100, item + 100);
    EXPECT_EQ(draw(narrow, 20000, item, item % 3, 3).samples, expected[item]) << item;
  }
}

TEST(NoiseFolder, WholeRecordingsBelongToPartsWhereThereAreEnough) {
  const core::TemporaryFolder folder;
  for (unsigned i = 0; i < 40; ++i) {
    write_sound(folder / (std::to_string(i) + ".wav"), some_noise(1600, i), 8000);
  }
  recording::NoiseFolder noise(folder.path(), {.sample_rate = 8000});
  std::map<std::string, std::size_t> part_of;
  for (std::size_t part = 0; part < 3; ++part) {
    for (std::uint64_t item = 0; item < 10; ++item) {
      for (const auto& segment : draw(noise, 8000, item, part, 3).segments) {
        EXPECT_EQ(part_of.emplace(segment.name, part).first->second, part) << segment.name;
      }
    }
  }
  EXPECT_GT(part_of.size(), 20u);
  // Another name, or more recordings, move none.
  std::filesystem::rename(folder / "0.wav", folder / "zero.wav");
  for (unsigned i = 40; i < 50; ++i) {
    write_sound(folder / (std::to_string(i) + ".wav"), some_noise(1600, i), 8000);
  }
  recording::NoiseFolder larger(folder.path(), {.sample_rate = 8000});
  for (std::size_t part = 0; part < 3; ++part) {
    for (std::uint64_t item = 0; item < 10; ++item) {
      for (const auto& segment : draw(larger, 8000, item, part, 3).segments) {
        const auto known = part_of.find(segment.name == "zero.wav" ? "0.wav" : segment.name);
        if (known != part_of.end()) {
          EXPECT_EQ(known->second, part) << segment.name;
        }
      }
    }
  }
}

TEST(NoiseFolder, FewRecordingsAreCutInTime) {
  // Each ninth of the recording is a tone of its own.
  const core::TemporaryFolder folder;
  std::vector<double> samples;
  const auto tone = [](std::size_t part) { return 500.0 + 400.0 * double(part); };
  for (std::size_t part = 0; part < 9; ++part) {
    const auto piece = sine(8000, tone(part), 16000);
    samples.insert(samples.end(), piece.begin(), piece.end());
  }
  write_sound(folder / "one.wav", samples, 16000);
  recording::NoiseFolder noise(folder.path(), {.sample_rate = 22050});
  for (std::size_t part = 0; part < 9; ++part) {
    for (std::uint64_t item = 0; item < 5; ++item) {
      const recording::NoiseDraw drawn = draw(noise, 22050, item, part, 9);
      const double own = tone_level(drawn.samples, tone(part), 22050);
      for (std::size_t other = 0; other < 9; ++other) {
        if (other == part) continue;
        EXPECT_LT(tone_level(drawn.samples, tone(other), 22050), own - 40) << part << other;
      }
      for (const auto& segment : drawn.segments) {
        EXPECT_GE(segment.start, 0.5 * double(part));
        EXPECT_LE(segment.start + segment.duration, 0.5 * double(part + 1) + 1e-4);
      }
    }
  }
}

TEST(NoiseFolder, ReadsRecordingsOfOthers) {
  const char* data = std::getenv("CARILLON_TEST_DATA");
  const std::filesystem::path noises = std::filesystem::path(data == nullptr ? "" : data) / "noise";
  if (!std::filesystem::is_directory(noises)) {
    GTEST_SKIP() << "set CARILLON_TEST_DATA to a folder with noise/";
  }
  recording::NoiseFolder noise(noises, {.memory = std::size_t{8} << 20});
  EXPECT_GT(noise.recordings().size(), 20u);
  for (const std::string& reason : noise.left_out()) {
    EXPECT_TRUE(reason.starts_with("MANIFEST.csv") || reason.starts_with("digital_silence") ||
                reason.starts_with("almost_silent") || reason.starts_with("fmt_float64"))
        << reason;
  }
  for (std::uint64_t item = 0; item < 20; ++item) {
    const recording::NoiseDraw drawn = draw(noise, 44100, item, item % 9, 9);
    EXPECT_EQ(drawn.samples.size(), 44100u);
    EXPECT_GT(power(drawn.samples), 0);
    for (double sample : drawn.samples) ASSERT_TRUE(std::isfinite(sample));
  }
}

}  // namespace
}  // namespace carillon::synth
