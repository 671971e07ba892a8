#include "core/audio.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <thread>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

std::uint32_t little_endian(const std::string& bytes, std::size_t at, int size) {
  std::uint32_t value = 0;
  for (int i = 0; i < size; ++i) {
    value |= std::uint32_t(static_cast<unsigned char>(bytes[at + std::size_t(i)])) << (8 * i);
  }
  return value;
}

/// Position of a RIFF chunk's content, by its four letters; npos when there is none.
std::size_t chunk(const std::string& bytes, const std::string& name) {
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    if (bytes.compare(at, 4, name) == 0) return at + 8;
    at += 8 + little_endian(bytes, at + 4, 4) + (little_endian(bytes, at + 4, 4) & 1);
  }
  return std::string::npos;
}

TEST(WriteWav, Float32KeepsEveryLevel) {
  const TemporaryFolder folder;
  EXPECT_TRUE(rc::check([&] {
    AudioClip clip;
    clip.channels = *rc::gen::inRange(1, 5);
    clip.sample_rate = *rc::gen::elementOf(std::vector<int>{8000, 44100, 96000});
    const auto frames = *rc::gen::inRange<std::size_t>(0, 50);
    for (std::size_t i = 0; i < frames * std::size_t(clip.channels); ++i) {
      clip.samples.push_back(*rc::gen::map(rc::gen::inRange(-2000000, 2000000),
                                           [](int n) { return static_cast<float>(n) * 1e-4F; }));
    }
    write_wav(folder / "a.wav", clip, SampleFormat::float32);
    const AudioClip back = read_audio(folder / "a.wav");
    RC_ASSERT(back.samples == clip.samples);
    RC_ASSERT(back.channels == clip.channels);
    RC_ASSERT(back.sample_rate == clip.sample_rate);
  }));
}

TEST(WriteWav, TheHeaderSaysWhatIsInside) {
  const TemporaryFolder folder;
  write_wav(folder / "a.wav", {{0.5F, -0.25F, 1e-30F, 7.5F}, 2, 48000}, SampleFormat::float32);
  const std::string bytes = read_file(folder / "a.wav");
  EXPECT_EQ(bytes.substr(0, 4) + bytes.substr(8, 4), "RIFFWAVE");
  const std::size_t format = chunk(bytes, "fmt ");
  ASSERT_NE(format, std::string::npos);
  EXPECT_EQ(little_endian(bytes, format, 2), 3u);  // IEEE float
  EXPECT_EQ(little_endian(bytes, format + 2, 2), 2u);
  EXPECT_EQ(little_endian(bytes, format + 4, 4), 48000u);
  EXPECT_EQ(little_endian(bytes, format + 14, 2), 32u);
  const std::size_t data = chunk(bytes, "data");
  ASSERT_NE(data, std::string::npos);
  float samples[4];
  std::memcpy(samples, bytes.data() + data, sizeof samples);
  EXPECT_EQ(samples[2], 1e-30F);
  EXPECT_EQ(samples[3], 7.5F);
}

TEST(WriteWav, EqualSamplesGiveEqualBytes) {
  const TemporaryFolder folder;
  const AudioClip clip{{0.1F, 0.9F, -0.3F}, 1, 44100};
  const auto write_both = [&](const std::string& name) {
    write_wav(folder / (name + "32.wav"), clip, SampleFormat::float32);
    write_wav(folder / (name + "16.wav"), clip, SampleFormat::int16);
  };
  write_both("a");
  // A PEAK chunk would hold the second of writing.
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  write_both("b");
  for (const char* bits : {"32.wav", "16.wav"}) {
    EXPECT_EQ(read_file(folder / ("a" + std::string(bits))),
              read_file(folder / ("b" + std::string(bits))));
  }
  EXPECT_EQ(chunk(read_file(folder / "a32.wav"), "PEAK"), std::string::npos);
}

TEST(WavBytes, AreThoseOfTheFile) {
  const TemporaryFolder folder;
  const AudioClip clip{{0.1F, 0.9F, -0.3F, 1.5F}, 2, 22050};
  for (const SampleFormat format : {SampleFormat::float32, SampleFormat::int16}) {
    write_wav(folder / "clip.wav", clip, format);
    EXPECT_EQ(wav_bytes("clip", clip, format), read_file(folder / "clip.wav"));
  }
  AudioClip broken = clip;
  broken.samples.pop_back();
  EXPECT_THROW(wav_bytes("clip", broken, SampleFormat::int16), FileError);
}

TEST(WriteWav, Int16RoundsToTheNearestAndClips) {
  const TemporaryFolder folder;
  const float step = 1.0F / 32768;
  const AudioClip clip{
      {0, 0.4F * step, 0.6F * step, -0.6F * step, 1000.49F * step, 1, -1, 1.7F, -3, 1e30F},
      1,
      44100};
  write_wav(folder / "a.wav", clip, SampleFormat::int16);
  const std::string bytes = read_file(folder / "a.wav");
  std::int16_t values[10];
  std::memcpy(values, bytes.data() + chunk(bytes, "data"), sizeof values);
  const std::int16_t expected[10] = {0, 0, 1, -1, 1000, 32767, -32768, 32767, -32768, 32767};
  for (int i = 0; i < 10; ++i) EXPECT_EQ(values[i], expected[i]) << i;
  std::int64_t clipped = 0;
  to_int16(clip.samples, &clipped);
  EXPECT_EQ(clipped, 4);  // not -1.0 itself
}

TEST(WriteWav, Int16ReadAndWrittenAgainIsUnchanged) {
  const TemporaryFolder folder;
  AudioClip clip;
  for (int value = -32768; value < 32768; ++value) {
    clip.samples.push_back(static_cast<float>(value) / 32768);
  }
  write_wav(folder / "a.wav", clip, SampleFormat::int16);
  const AudioClip back = read_audio(folder / "a.wav");
  EXPECT_EQ(back.samples, clip.samples);
}

TEST(WriteWav, RefusesWhatIsNoSound) {
  const TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  const auto refused = [&](const AudioClip& clip) {
    EXPECT_THROW(write_wav(folder / "a.wav", clip, SampleFormat::int16), FileError);
    EXPECT_FALSE(std::filesystem::exists(folder / "a.wav"));
  };
  refused({{0, nan}, 1, 44100});
  refused({{infinity}, 1, 44100});
  refused({{0, 0, 0}, 2, 44100});
  refused({{0}, 0, 44100});
  refused({{0}, 1, 0});
  EXPECT_THROW(write_wav(folder / "absent/a.wav", {{0}, 1, 44100}, SampleFormat::int16), FileError);
}

TEST(ReadAudio, NamesTheFileAndTheReason) {
  const TemporaryFolder folder;
  write_text_durably(folder / "text.wav", "not a sound at all");
  write_text_durably(folder / "picture.wav", "\x89PNG\r\n\x1a\n");
  for (const char* reason : {"absent.wav: no such file", "text.wav: cannot be read: ",
                             "picture.wav is a PNG picture; a recording is wanted"}) {
    const std::string text = reason;
    try {
      read_audio(folder / text.substr(0, text.find_first_of(": ")));
      FAIL() << reason;
    } catch (const FileError& error) {
      EXPECT_NE(error.message().find(reason), std::string::npos) << error.message();
    }
  }
}

/// A chunk of a RIFF file, its size as told.
std::string sized_chunk(const std::string& name, const std::string& bytes, std::uint32_t size) {
  std::string text = name;
  for (int k = 0; k < 4; ++k) text += static_cast<char>(size >> (8 * k) & 0xff);
  return text + bytes;
}
std::string riff_chunk(const std::string& name, const std::string& bytes) {
  return sized_chunk(name, bytes, static_cast<std::uint32_t>(bytes.size()));
}

class Headers : public testing::Test {
 protected:
  void SetUp() override {
    write_wav(folder / "good.wav", {{0.5F, -0.25F, 0.125F, 0}, 1, 8000}, SampleFormat::int16);
    const std::string good = read_file(folder / "good.wav");
    format = good.substr(good.find("fmt "), 24);
    samples = good.substr(good.find("data") + 8, 8);
  }
  std::filesystem::path write(const std::string& name, const std::string& bytes) {
    std::ofstream(folder / name, std::ios::binary) << bytes;
    return folder / name;
  }
  void expect_the_sound(const std::filesystem::path& path) {
    const AudioClip clip = read_audio(path);
    EXPECT_EQ(clip.samples, (std::vector<float>{0.5F, -0.25F, 0.125F, 0})) << path;
    EXPECT_EQ(clip.sample_rate, 8000);
    EXPECT_EQ(read_audio_header(path).seconds, 4.0 / 8000);
  }
  void expect_reason(const std::filesystem::path& path, const std::string& reason) {
    try {
      read_audio(path);
      ADD_FAILURE() << path << " was read";
    } catch (const FileError& error) {
      EXPECT_NE(error.message().find(reason), std::string::npos) << error.message();
      EXPECT_NE(error.hint(), "") << path;
    }
  }
  const TemporaryFolder folder;
  std::string format, samples;
};

TEST_F(Headers, OfARecorderThatWasCutOffAreReadToTheEnd) {
  expect_the_sound(
      write("cut.wav", sized_chunk("RIFF", "WAVE", 0) + format + sized_chunk("data", samples, 0)));
  // Chunks in place of samples: there are none.
  const auto empty = write("empty.wav", sized_chunk("RIFF", "WAVE", 44) + format +
                                            riff_chunk("data", "") + riff_chunk("LIST", "abcd"));
  EXPECT_TRUE(read_audio(empty).samples.empty());
}

TEST_F(Headers, OfBw64AreThoseOfRf64) {
  std::string sizes(28, '\0');
  sizes[8] = 8;   // of data
  sizes[16] = 4;  // samples
  const std::string rest =
      "WAVE" + riff_chunk("ds64", sizes) + format + sized_chunk("data", samples, ~0U);
  expect_the_sound(write("a.wav", sized_chunk("BW64", rest, ~0U)));
  expect_the_sound(write("b.wav", sized_chunk("RF64", rest, ~0U)));
}

TEST_F(Headers, ThatAreDamagedGiveAReason) {
  expect_reason(
      write("late.wav", riff_chunk("RIFF", "WAVE" + riff_chunk("data", samples) + format)),
      "format chunk comes after its data chunk");
  expect_reason(write("odd.wav", riff_chunk("RIFF", "WAVE" + format + riff_chunk("LIST", "abcde") +
                                                        riff_chunk("data", samples))),
                "chunk LIST has an odd size");
  expect_reason(write("no_data.wav", riff_chunk("RIFF", "WAVE" + format)), "no data chunk");
  expect_reason(write("no_format.wav", riff_chunk("RIFF", "WAVE" + riff_chunk("data", samples))),
                "no format chunk");
  expect_reason(write("named.mp3", std::string("\0\0\0\x1c", 4) + "ftypisom" + samples), "AAC");
  expect_reason(write("adts.mp3", "\xff\xf1\x50\x80" + samples), "is AAC, which is not read");
  expect_reason(write("text.wav", "not a sound at all"), "no format of sound that is known");
}

TEST(ReadAudio, DamagedFilesGiveASoundOrAnError) {
  const TemporaryFolder folder;
  write_wav(folder / "good.wav", {std::vector<float>(64, 0.5F), 2, 44100}, SampleFormat::int16);
  const std::string good = read_file(folder / "good.wav");
  EXPECT_TRUE(rc::check([&] {
    std::string bytes = good.substr(0, *rc::gen::inRange<std::size_t>(0, good.size() + 1));
    for (int i = *rc::gen::inRange(0, 4); i > 0 && !bytes.empty(); --i) {
      const auto at = *rc::gen::inRange<std::size_t>(0, std::min<std::size_t>(bytes.size(), 48));
      bytes[at] = static_cast<char>(*rc::gen::inRange(0, 256));
    }
    std::ofstream(folder / "damaged.wav", std::ios::binary) << bytes;
    try {
      const AudioClip clip = read_audio(folder / "damaged.wav");
      RC_ASSERT(clip.channels > 0);
      RC_ASSERT(clip.samples.size() % std::size_t(clip.channels) == 0u);
    } catch (const FileError& error) {
      RC_ASSERT(!error.message().empty());
    }
  }));
}

}  // namespace
}  // namespace carillon::core
