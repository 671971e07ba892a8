#include "synth/recording/codec.hpp"

#include <fmt/format.h>
#include <sndfile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>

#include "core/error.hpp"
#include "synth/signal/resample.hpp"

namespace carillon::synth::recording {

namespace {

constexpr double max_compression = 0.9;

/// A file in memory, as libsndfile asks for it.
struct MemoryFile {
  std::vector<char> bytes;
  sf_count_t place = 0;

  sf_count_t size() const { return static_cast<sf_count_t>(bytes.size()); }
  static MemoryFile& of(void* user) { return *static_cast<MemoryFile*>(user); }
};

sf_count_t length_of(void* user) {
  return MemoryFile::of(user).size();
}

sf_count_t seek_to(sf_count_t offset, int whence, void* user) {
  MemoryFile& file = MemoryFile::of(user);
  const sf_count_t from = whence == SEEK_SET ? 0 : whence == SEEK_CUR ? file.place : file.size();
  file.place = from + offset;
  return file.place;
}

sf_count_t read_from(void* bytes, sf_count_t count, void* user) {
  MemoryFile& file = MemoryFile::of(user);
  const sf_count_t there = std::clamp<sf_count_t>(file.size() - file.place, 0, count);
  std::memcpy(bytes, file.bytes.data() + file.place, static_cast<std::size_t>(there));
  file.place += there;
  return there;
}

sf_count_t write_to(const void* bytes, sf_count_t count, void* user) {
  MemoryFile& file = MemoryFile::of(user);
  const auto end = static_cast<std::size_t>(file.place + count);
  if (file.bytes.size() < end) file.bytes.resize(end);
  std::memcpy(file.bytes.data() + file.place, bytes, static_cast<std::size_t>(count));
  file.place += count;
  return count;
}

sf_count_t place_in(void* user) {
  return MemoryFile::of(user).place;
}

using OpenFile = std::unique_ptr<SNDFILE, int (*)(SNDFILE*)>;

OpenFile open(MemoryFile& file, int mode, SF_INFO& info, const std::string& codec) {
  SF_VIRTUAL_IO access = {length_of, seek_to, read_from, write_to, place_in};
  OpenFile opened(sf_open_virtual(&access, mode, &info, &file), sf_close);
  if (!opened) {
    throw core::FileError(fmt::format("{}: {}", codec, sf_strerror(nullptr)),
                          "libsndfile 1.1 and later have MP3; Vorbis and Opus are options of it");
  }
  return opened;
}

int format_of(Codec codec) {
  switch (codec) {
    case Codec::mp3:
      return SF_FORMAT_MPEG | SF_FORMAT_MPEG_LAYER_III;
    case Codec::vorbis:
      return SF_FORMAT_OGG | SF_FORMAT_VORBIS;
    case Codec::opus:
    case Codec::none:
      break;
  }
  return SF_FORMAT_OGG | SF_FORMAT_OPUS;
}

/// The clip's own where the codec takes it.
int rate_of(Codec codec, double sample_rate) {
  static constexpr std::array<int, 5> of_opus = {8000, 12000, 16000, 24000, 48000};
  static constexpr std::array<int, 9> of_mp3 = {8000,  11025, 12000, 16000, 22050,
                                                24000, 32000, 44100, 48000};
  const auto nearest_above = [&](std::span<const int> rates) {
    const auto found =
        std::find_if(rates.begin(), rates.end(), [&](int rate) { return rate >= sample_rate; });
    return found == rates.end() ? rates.back() : *found;
  };
  if (codec == Codec::opus) return nearest_above(of_opus);
  if (codec == Codec::mp3) return nearest_above(of_mp3);
  return static_cast<int>(std::lround(std::min(sample_rate, 192000.0)));
}

}  // namespace

const std::vector<std::string>& codec_names() {
  static const std::vector<std::string> names = {"none", "mp3", "vorbis", "opus"};
  return names;
}

void pass_through(Codec codec, double compression, std::span<float> clip, double sample_rate) {
  if (!(compression >= 0 && compression <= max_compression)) {
    throw core::InputError(fmt::format("a compression of {}", compression),
                           fmt::format("0 to {}", max_compression));
  }
  const auto broken =
      std::find_if(clip.begin(), clip.end(), [](float sample) { return !std::isfinite(sample); });
  if (broken != clip.end()) throw core::InputError("a sample is not finite: it cannot be encoded");
  if (codec == Codec::none || clip.empty()) return;
  const std::string& name = codec_names()[static_cast<std::size_t>(codec)];
  const int rate = rate_of(codec, sample_rate);
  const std::vector<double> samples(clip.begin(), clip.end());
  const std::vector<double> own = synth::signal::resample(samples, sample_rate, rate);
  std::vector<double> decoded(own.size(), 0.0);
  MemoryFile file;
  {
    SF_INFO info{};
    info.samplerate = rate;
    info.channels = 1;
    info.format = format_of(codec);
    const OpenFile writing = open(file, SFM_WRITE, info, name);
    sf_command(writing.get(), SFC_SET_COMPRESSION_LEVEL, &compression, sizeof compression);
    sf_writef_double(writing.get(), own.data(), static_cast<sf_count_t>(own.size()));
  }
  file.place = 0;
  SF_INFO info{};
  const OpenFile reading = open(file, SFM_READ, info, name);
  sf_readf_double(reading.get(), decoded.data(), static_cast<sf_count_t>(decoded.size()));
  const std::vector<double> back = synth::signal::resample(decoded, rate, sample_rate);
  for (std::size_t i = 0; i < clip.size(); ++i) {
    clip[i] = i < back.size() ? static_cast<float>(back[i]) : 0.0F;
  }
}

}  // namespace carillon::synth::recording
