// Measured responses of rooms: where they begin, how loud they are, and who gets which.
#include "synth/room/measured_responses.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "sound_files.hpp"
#include "synth/room/detail/reverberation_time.hpp"
#include "synth/room/room.hpp"

namespace carillon::synth::room {
namespace {

std::vector<double> pulse(std::size_t count, std::size_t at, double level) {
  std::vector<double> samples(count, 0.0);
  samples[at] = level;
  return samples;
}

double energy(std::span<const float> samples, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t i = begin; i < std::min(end, samples.size()); ++i) {
    sum += static_cast<double>(samples[i]) * samples[i];
  }
  return sum;
}

/// Magnitude of a response at a frequency.
double gain(std::span<const float> samples, double frequency, double rate) {
  double re = 0, im = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double phase = 2 * std::numbers::pi * frequency * static_cast<double>(i) / rate;
    re += samples[i] * std::cos(phase);
    im += samples[i] * std::sin(phase);
  }
  return std::hypot(re, im);
}

TEST(FromDirectSound, ADelayedPulseOfAnyLevelIsAPulseOfOne) {
  for (const double level : {1.0, -0.25, 3e-6, 1e4}) {
    const auto made = from_direct_sound(pulse(2000, 700, level), 44100, {});
    ASSERT_EQ(made.size(), 1300u);
    EXPECT_FLOAT_EQ(made[0], level > 0 ? 1.0F : -1.0F);
    EXPECT_EQ(energy(made, 1, made.size()), 0);
  }
}

TEST(FromDirectSound, KeepsTheOrderAndTheRatiosOfWhatFollows) {
  std::vector<double> samples = pulse(3000, 100, 0.5);
  samples[100 + 400] = -0.2;
  samples[100 + 1500] = 0.05;
  const auto made = from_direct_sound(samples, 44100, {});
  EXPECT_FLOAT_EQ(made[0], 1);
  EXPECT_FLOAT_EQ(made[400], -0.4F);
  EXPECT_FLOAT_EQ(made[1500], 0.1F);
}

// What a loudspeaker makes of a pulse has several samples; together they have the energy of one.
TEST(FromDirectSound, TheEnergyOfTheDirectSoundIsOne) {
  std::vector<double> samples = some_noise(44100, 5);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] *= std::exp(-static_cast<double>(i) / 4000);
  }
  for (const double rate : {8000.0, 16000.0, 44100.0, 96000.0}) {
    MeasuredOptions options;
    options.sample_rate = rate;
    options.count = static_cast<std::size_t>(rate);
    const auto made = from_direct_sound(samples, 44100, options);
    const auto direct = static_cast<std::size_t>(std::ceil(direct_seconds * rate));
    EXPECT_NEAR(energy(made, 0, direct), 1, 1e-6) << rate;
  }
}

TEST(FromDirectSound, BeginsWithinTwentyDecibelsOfTheLoudest) {
  std::vector<double> samples = pulse(4000, 1000, 1);
  samples[500] = 0.09;  // noise before the sound
  samples[800] = 0.11;  // a direct sound that is weaker than a reflection
  const auto made = from_direct_sound(samples, 44100, {});
  EXPECT_EQ(made.size(), 3200u);
  EXPECT_NEAR(made[200] / made[0], 1 / 0.11, 1e-4);
}

TEST(FromDirectSound, HoldsNoMoreThanAClipHears) {
  MeasuredOptions options;
  options.count = 500;
  EXPECT_EQ(from_direct_sound(some_noise(44100, 1), 44100, options).size(), 500u);
  EXPECT_EQ(from_direct_sound(some_noise(96000, 1), 96000, options).size(), 500u);
}

// Up to 0.9 of half the lower rate a pulse stays even: as a filter it has no level of its own.
TEST(FromDirectSound, APulseIsEvenAtAnotherRate) {
  for (const double rate : {96000.0, 48000.0, 32000.0}) {
    MeasuredOptions options;
    options.sample_rate = 22050;
    const auto made = from_direct_sound(pulse(4000, 777, 0.3), rate, options);
    EXPECT_GT(made[0], 0.97F) << rate;
    for (const double frequency : {50.0, 500.0, 2000.0, 6000.0, 9000.0}) {
      EXPECT_NEAR(20 * std::log10(gain(made, frequency, 22050)), 0, 0.5)
          << rate << " " << frequency;
    }
  }
}

// A response of 8 kHz says nothing of what is above 4 kHz, and must not make it up.
TEST(FromDirectSound, OfALowRateHasNothingAboveIt) {
  const auto made = from_direct_sound(pulse(800, 100, 1), 8000, {});
  const double within = gain(made, 1000, 44100);
  for (const double frequency : {5000.0, 8000.0, 12000.0, 20000.0}) {
    EXPECT_LT(gain(made, frequency, 44100), 0.06 * within) << frequency;
  }
}

TEST(FromDirectSound, ReflectionsComeAsLongAfterTheDirectSound) {
  std::vector<double> samples = pulse(48000, 4800, 1);
  samples[4800 + 4800] = 0.5;  // 0.1 s
  for (const double rate : {16000.0, 44100.0, 48000.0, 96000.0}) {
    MeasuredOptions options;
    options.sample_rate = rate;
    options.count = static_cast<std::size_t>(rate);
    const auto made = from_direct_sound(samples, 48000, options);
    const std::span all(made);
    const auto middle = static_cast<std::size_t>(0.05 * rate);
    const auto loudest = [](std::span<const float> part) {
      return std::max_element(part.begin(), part.end()) - part.begin();
    };
    EXPECT_NEAR(static_cast<double>(static_cast<std::ptrdiff_t>(middle) +
                                    loudest(all.subspan(middle)) - loudest(all.first(middle))),
                0.1 * rate, 1)
        << rate;
  }
}

TEST(FromDirectSound, KeepsTheReverberationTime) {
  constexpr double rt60 = 0.4;
  std::vector<double> samples = some_noise(48000, 9);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] *= std::pow(10.0, -3 * static_cast<double>(i) / (48000 * rt60));
  }
  samples.insert(samples.begin(), 3000, 0.0);
  for (const double rate : {8000.0, 16000.0, 44100.0}) {
    MeasuredOptions options;
    options.sample_rate = rate;
    options.count = static_cast<std::size_t>(rate);
    const auto made = from_direct_sound(samples, 48000, options);
    const std::vector<double> response(made.begin(), made.end());
    const auto fit = reverberation_time(response, rate);
    ASSERT_TRUE(fit) << rate;
    EXPECT_NEAR(fit->rt60, rt60, 0.03 * rt60) << rate;
  }
}

// A simulated response, delayed and at another level, is found as it was.
TEST(FromDirectSound, FindsASimulatedRoom) {
  RoomOptions room;
  room.count = 22050;
  room.walls = same_on_all_walls({0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3});
  const RoomResponse simulated = room_response(room);
  std::vector<double> samples(1000 + room.count, 0.0);
  samples[1000] = 0.02;
  for (const std::vector<double>* part : {&simulated.images, &simulated.tail}) {
    for (std::size_t i = 0; i < part->size(); ++i) samples[1000 + i] += 0.02 * (*part)[i];
  }
  const auto made = from_direct_sound(samples, 44100, {});
  ASSERT_EQ(made.size(), room.count);
  for (std::size_t i = 0; i < made.size(); ++i) {
    ASSERT_NEAR(made[i] * 0.02 / made[0], samples[1000 + i], 1e-7) << i;
  }
}

/// `count` files of different content, every third at 16 kHz.
void fill(const core::TemporaryFolder& folder, std::size_t count) {
  for (std::size_t k = 0; k < count; ++k) {
    std::vector<double> samples = some_noise(500, static_cast<unsigned>(k));
    samples[0] = 1;
    write_sound(folder / fmt::format("{:03}.wav", k), samples, k % 3 == 0 ? 16000 : 44100);
  }
}

std::vector<std::set<std::string>> names_of_parts(const core::TemporaryFolder& folder,
                                                  std::size_t parts) {
  MeasuredOptions options;
  options.parts = parts;
  const MeasuredResponses responses(folder.path(), options);
  std::vector<std::set<std::string>> names(parts);
  for (std::size_t part = 0; part < parts; ++part) {
    for (std::uint64_t id = 0; id < 400; ++id) {
      core::RandomStream random(1, id, "test.responses");
      names[part].insert(responses.draw(part, random).name);
    }
  }
  return names;
}

void expect_a_division(const std::vector<std::set<std::string>>& parts, std::size_t files) {
  std::set<std::string> all;
  std::size_t sum = 0;
  for (const auto& part : parts) {
    EXPECT_FALSE(part.empty());
    sum += part.size();
    all.insert(part.begin(), part.end());
  }
  EXPECT_EQ(sum, all.size()) << "a file is in two parts";
  EXPECT_EQ(all.size(), files);
}

TEST(MeasuredResponses, PartsShareNoFile) {
  for (const std::size_t files : {9, 10, 23, 60}) {
    const core::TemporaryFolder folder;
    fill(folder, files);
    expect_a_division(names_of_parts(folder, 9), files);
  }
}

TEST(MeasuredResponses, FilesOfEnoughStayInTheirPartsWhenMoreAreAdded) {
  const core::TemporaryFolder folder;
  fill(folder, 40);
  const auto before = names_of_parts(folder, 4);
  fill(folder, 60);
  const auto after = names_of_parts(folder, 4);
  for (std::size_t part = 0; part < 4; ++part) {
    for (const std::string& name : before[part]) EXPECT_TRUE(after[part].contains(name)) << name;
  }
}

TEST(MeasuredResponses, NamesDoNotCount) {
  const core::TemporaryFolder folder, other;
  fill(folder, 12);
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    std::filesystem::copy(entry, other / ("b" + entry.path().filename().string()));
  }
  const auto parts = names_of_parts(folder, 4), renamed = names_of_parts(other, 4);
  for (std::size_t part = 0; part < 4; ++part) {
    for (const std::string& name : parts[part]) EXPECT_TRUE(renamed[part].contains("b" + name));
  }
}

TEST(MeasuredResponses, OfEqualContentOneIsUsed) {
  const core::TemporaryFolder folder;
  fill(folder, 2);
  std::filesystem::copy(folder / "000.wav", folder / "copy.wav");
  const MeasuredResponses responses(folder.path(), {});
  EXPECT_EQ(responses.all().size(), 2u);
  EXPECT_EQ(responses.left_out(), std::vector<std::string>{"copy.wav: the same as 000.wav"});
}

TEST(MeasuredResponses, EveryChannelIsAResponseOrOneIsChosen) {
  const core::TemporaryFolder folder;
  std::vector<double> samples;
  for (int i = 0; i < 300; ++i) {
    samples.push_back(i == 0 ? 1 : 0);
    samples.push_back(i == 20 ? 0.5 : i == 220 ? 0.25 : 0);
  }
  write_sound(folder / "two.wav", samples, 44100, 2);
  const MeasuredResponses both(folder.path(), {});
  ASSERT_EQ(both.all().size(), 2u);
  EXPECT_EQ(both.all()[0].channel, 1);
  EXPECT_EQ(both.all()[1].channel, 2);
  EXPECT_FLOAT_EQ(both.all()[1].samples[200], 0.5F);
  std::set<int> drawn;
  for (std::uint64_t id = 0; id < 40; ++id) {
    core::RandomStream random(1, id, "test.channels");
    drawn.insert(both.draw(0, random).channel);
  }
  EXPECT_EQ(drawn, (std::set<int>{1, 2}));
  MeasuredOptions second;
  second.channel = 2;
  const MeasuredResponses one(folder.path(), second);
  ASSERT_EQ(one.all().size(), 1u);
  EXPECT_EQ(one.all()[0].channel, 2);
  EXPECT_EQ(one.all()[0].samples, both.all()[1].samples);
}

TEST(MeasuredResponses, AFileIsTheSameInAllParts) {
  const core::TemporaryFolder folder;
  fill(folder, 2);
  MeasuredOptions options;
  options.parts = 9;
  const MeasuredResponses responses(folder / "001.wav", options);
  for (std::size_t part = 0; part < 9; ++part) {
    core::RandomStream random(1, part, "test.responses");
    EXPECT_EQ(responses.draw(part, random).name, "001.wav");
  }
}

TEST(SharedResponses, AreReadOnceAndAgainWhenAFileChanges) {
  const core::TemporaryFolder folder;
  fill(folder, 3);
  const auto first = shared_responses(folder.path(), {});
  EXPECT_EQ(shared_responses(folder.path(), {}), first);
  MeasuredOptions slow;
  slow.sample_rate = 8000;
  EXPECT_NE(shared_responses(folder.path(), slow), first);
  const auto again = shared_responses(folder.path(), {});
  write_sound(folder / "001.wav", some_noise(700, 99), 44100);
  const auto changed = shared_responses(folder.path(), {});
  EXPECT_NE(changed, again);
  EXPECT_EQ(changed->all()[1].samples.size(), 700u);
}

TEST(MeasuredSize, IsWhatIsKept) {
  const core::TemporaryFolder folder;
  fill(folder, 6);
  const MeasuredResponses responses(folder.path(), {});
  double bytes = 0;
  for (const MeasuredResponse& response : responses.all()) {
    bytes += static_cast<double>(response.samples.size() * sizeof(float));
  }
  const MeasuredSize size = measured_size(folder.path(), {});
  EXPECT_EQ(size.responses, 6u);
  EXPECT_NEAR(size.bytes, bytes, 0.3 * bytes);
  EXPECT_EQ(measured_size(folder / "absent", {}).responses, 0u);
}

}  // namespace
}  // namespace carillon::synth::room
