#include "core/audio.hpp"

#include <fmt/format.h>
#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/handle.hpp"
#include "core/sound_file.hpp"

namespace carillon::core {

namespace {

void close_file(SNDFILE** file) {
  sf_close(*file);
}
using WrittenFile = Handle<SNDFILE*, close_file, nullptr>;

void check_clip(const std::string& name, const AudioClip& clip) {
  if (clip.channels < 1 || clip.sample_rate < 1 ||
      clip.samples.size() % static_cast<std::size_t>(clip.channels) != 0) {
    throw FileError(fmt::format("{}: {} samples do not make whole frames of {} channels at {} Hz",
                                name, clip.samples.size(), clip.channels, clip.sample_rate));
  }
  const auto bad = std::find_if(clip.samples.begin(), clip.samples.end(),
                                [](float sample) { return !std::isfinite(sample); });
  if (bad != clip.samples.end()) {
    throw FileError(
        fmt::format("{}: sample {} is not a finite number", name, bad - clip.samples.begin()));
  }
}

/// A WAV file in memory, as libsndfile writes it.
struct Bytes {
  std::string all;
  std::size_t place = 0;
};

SF_VIRTUAL_IO bytes_io() {
  SF_VIRTUAL_IO io{};
  io.get_filelen = [](void* to) -> sf_count_t {
    return static_cast<sf_count_t>(static_cast<Bytes*>(to)->all.size());
  };
  io.seek = [](sf_count_t offset, int whence, void* to) -> sf_count_t {
    Bytes& bytes = *static_cast<Bytes*>(to);
    const sf_count_t from = whence == SEEK_SET   ? 0
                            : whence == SEEK_CUR ? static_cast<sf_count_t>(bytes.place)
                                                 : static_cast<sf_count_t>(bytes.all.size());
    bytes.place = static_cast<std::size_t>(from + offset);
    return from + offset;
  };
  io.read = [](void*, sf_count_t, void*) -> sf_count_t { return 0; };
  io.write = [](const void* from, sf_count_t count, void* to) -> sf_count_t {
    Bytes& bytes = *static_cast<Bytes*>(to);
    const auto size = static_cast<std::size_t>(count);
    if (bytes.all.size() < bytes.place + size) bytes.all.resize(bytes.place + size);
    std::memcpy(bytes.all.data() + bytes.place, from, size);
    bytes.place += size;
    return count;
  };
  io.tell = [](void* to) -> sf_count_t {
    return static_cast<sf_count_t>(static_cast<Bytes*>(to)->place);
  };
  return io;
}

/// @param open  opens the file to be written
template <class Open>
void write(const std::string& name, const AudioClip& clip, SampleFormat format, Open&& open) {
  check_clip(name, clip);
  SF_INFO info{};
  info.channels = clip.channels;
  info.samplerate = clip.sample_rate;
  info.format =
      SF_FORMAT_WAV | (format == SampleFormat::float32 ? SF_FORMAT_FLOAT : SF_FORMAT_PCM_16);
  WrittenFile file(open(&info));
  if (file.get() == nullptr) {
    throw FileError(fmt::format("{}: cannot be written: {}", name, sf_strerror(nullptr)));
  }
  // The PEAK chunk holds the time of writing.
  sf_command(file.get(), SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
  const auto count = static_cast<sf_count_t>(clip.samples.size());
  sf_count_t written = 0;
  if (format == SampleFormat::float32) {
    written = sf_write_float(file.get(), clip.samples.data(), count);
  } else {
    const std::vector<std::int16_t> rounded = to_int16(clip.samples);
    written = sf_write_short(file.get(), rounded.data(), count);
  }
  std::string reason = sf_strerror(file.get());
  // The header is completed on closing, so closing may fail too.
  const int closed = sf_close(std::exchange(*file.put(), nullptr));
  if (written == count && closed == 0) return;
  if (written == count) reason = sf_error_number(closed);
  throw FileError(fmt::format("{}: cannot be written: {}", name, reason));
}

}  // namespace

std::vector<std::int16_t> to_int16(std::span<const float> samples, std::int64_t* clipped) {
  std::vector<std::int16_t> rounded;
  rounded.reserve(samples.size());
  for (const float sample : samples) {
    const float scaled = std::nearbyint(sample * int16_full_scale);
    const float held = std::clamp(scaled, -int16_full_scale, int16_full_scale - 1);
    if (held != scaled && clipped != nullptr) ++*clipped;
    rounded.push_back(static_cast<std::int16_t>(held));
  }
  return rounded;
}

void write_wav(const std::filesystem::path& path, const AudioClip& clip, SampleFormat format) {
  write(path.string(), clip, format,
        [&](SF_INFO* info) { return sf_open(path.c_str(), SFM_WRITE, info); });
}

std::string wav_bytes(const std::string& name, const AudioClip& clip, SampleFormat format) {
  Bytes bytes;
  SF_VIRTUAL_IO io = bytes_io();
  write(name, clip, format,
        [&](SF_INFO* info) { return sf_open_virtual(&io, SFM_WRITE, info, &bytes); });
  return std::move(bytes.all);
}

AudioHeader read_audio_header(const std::filesystem::path& path) {
  const SoundFile file(path);
  return {file.info().channels, file.info().samplerate,
          static_cast<double>(file.info().frames) / static_cast<double>(file.info().samplerate)};
}

AudioClip read_audio(const std::filesystem::path& path) {
  SoundFile file(path);
  AudioClip clip;
  clip.channels = file.info().channels;
  clip.sample_rate = file.info().samplerate;
  // The header's length may be anything in a damaged file, so what is read decides.
  const auto channels = static_cast<std::size_t>(clip.channels);
  std::vector<float> block(4096 * channels);
  while (true) {
    const sf_count_t frames = sf_readf_float(file.get(), block.data(), 4096);
    if (frames <= 0) break;
    const auto count = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(frames) * channels);
    clip.samples.insert(clip.samples.end(), block.begin(), block.begin() + count);
  }
  if (const int code = sf_error(file.get()); code != SF_ERR_NO_ERROR) {
    throw FileError(fmt::format("{}: cannot be read: {}", path.string(), sound_fault(code)));
  }
  return clip;
}

}  // namespace carillon::core
