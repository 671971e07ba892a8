#include "core/sound_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/what_is.hpp"

namespace carillon::core {

namespace {

std::string bytes_at(std::ifstream& file, std::int64_t place, std::size_t count) {
  std::string bytes(count, '\0');
  file.clear();
  file.seekg(place);
  file.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  file.clear();
  return bytes;
}

std::uint32_t little_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t k = 4; k-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[k]);
  return value;
}

/// A chunk of a RIFF file.
struct Chunk {
  std::string name;
  std::int64_t place = 0;  ///< of its name
  std::int64_t size = 0;   ///< as it says
};

bool is_chunk_name(std::string_view bytes) {
  return bytes.size() >= 4 && std::all_of(bytes.begin(), bytes.begin() + 4, [](char letter) {
           return letter >= ' ' && letter <= '~';
         });
}

/// Chunks up to the first that has no name or lies beyond the end.
std::vector<Chunk> chunks_of(std::ifstream& file, std::int64_t size, std::int64_t from = 12) {
  constexpr std::size_t maximum = 1000;
  std::vector<Chunk> chunks;
  for (std::int64_t place = from; place + 8 <= size && chunks.size() < maximum;) {
    const std::string head = bytes_at(file, place, 8);
    if (!is_chunk_name(head)) break;
    const std::int64_t length = little_endian(std::string_view(head).substr(4));
    chunks.push_back({head.substr(0, 4), place, length});
    place += 8 + length + length % 2;
  }
  return chunks;
}

/// What is wrong with the chunks of a WAV file that cannot be read; "" where nothing is seen.
std::string chunk_fault(std::ifstream& file, std::int64_t size) {
  const std::vector<Chunk> chunks = chunks_of(file, size);
  const auto named = [&](const char* name) {
    return std::find_if(chunks.begin(), chunks.end(),
                        [&](const Chunk& chunk) { return chunk.name == name; });
  };
  const auto format = named("fmt "), data = named("data");
  if (data != chunks.end() && format == chunks.end()) {
    return "it has no format chunk before its data chunk";
  }
  if (data != chunks.end() && data < format) {
    return "its format chunk comes after its data chunk, where readers do not look";
  }
  for (const Chunk& chunk : chunks) {
    const std::int64_t next = chunk.place + 8 + chunk.size;
    if (chunk.size % 2 == 1 && is_chunk_name(bytes_at(file, next, 4)) &&
        bytes_at(file, next, 1) != std::string(1, '\0')) {
      return fmt::format("its chunk {} has an odd size and no byte of padding after it",
                         chunk.name);
    }
  }
  if (data == chunks.end()) return "it has no data chunk";
  return "";
}

constexpr const char* convert =
    "convert it, e.g. ffmpeg -i {} sound.wav; WAV, FLAC, Ogg, Opus and MP3 are read";

[[noreturn]] void refuse(const std::filesystem::path& path, std::ifstream& file, std::int64_t size,
                         int code) {
  const WhatIs what = what_is(path);
  const std::string name = path.string();
  if (what.name == "missing") throw FileError(fmt::format("{}: no such file", name));
  if (!what.sound && what.name != "a file") {
    throw FileError(fmt::format("{} is {}; a recording is wanted", name, what.name),
                    "WAV, FLAC, Ogg or any other file that libsndfile reads");
  }
  std::string fault;
  if (bytes_at(file, 0, 4) == "RIFF" && bytes_at(file, 8, 4) == "WAVE") {
    fault = chunk_fault(file, size);
  }
  if (fault.empty()) fault = sound_fault(code);
  throw FileError(fmt::format("{}: cannot be read: {}", name, fault),
                  fmt::format(fmt::runtime(convert), name));
}

/// Formats of sound that libsndfile does not read, by their first bytes.
std::optional<std::string> foreign_format(std::string_view head) {
  const auto has = [&](std::size_t place, std::string_view text) {
    return head.size() >= place + text.size() && head.substr(place, text.size()) == text;
  };
  if (has(4, "ftyp")) return "MP4 or M4A, mostly with AAC";
  if (has(0, "\x30\x26\xb2\x75")) return "Windows Media";
  if (has(0, "\x1a\x45\xdf\xa3")) return "Matroska or WebM";
  if (has(0, "#!AMR")) return "AMR";
  if (has(0, "MThd")) return "MIDI, which holds notes and no sound";
  if (has(0, "wvpk")) return "WavPack";
  if (has(0, "MAC ")) return "Monkey's Audio";
  if (has(0, "RIFF") && has(8, "AVI ")) return "AVI";
  // A frame of ADTS: twelve bits of synchronisation, then layer 0, which MP3 does not have.
  if (head.size() > 1 && head[0] == '\xff' &&
      (static_cast<unsigned char>(head[1]) & 0xf6U) == 0xf0U) {
    return "AAC";
  }
  return std::nullopt;
}

}  // namespace

const char* sound_fault(int code) {
  switch (code) {
    case SF_ERR_UNRECOGNISED_FORMAT:
      return "it is of no format of sound that is known here";
    case SF_ERR_UNSUPPORTED_ENCODING:
      return "its samples are encoded in a way that is not known here";
    case SF_ERR_SYSTEM:
      return "the system does not let it be read";
    default:
      return "it is damaged";
  }
}

SoundFile::SoundFile(const std::filesystem::path& path) {
  source_.file.open(path, std::ios::binary);
  std::error_code error;
  source_.size = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  if (error || !source_.file || !std::filesystem::is_regular_file(path, error)) {
    refuse(path, source_.file, 0, SF_ERR_SYSTEM);
  }
  const std::string head = bytes_at(source_.file, 0, 16);
  if (const auto foreign = foreign_format(head)) {
    throw FileError(fmt::format("{} is {}, which is not read", path.string(), *foreign),
                    fmt::format(fmt::runtime(convert), path.string()));
  }
  const auto change = [&](std::int64_t place, std::string_view bytes) {
    for (const char byte : bytes) source_.changed[place++] = byte;
  };
  if (head.starts_with("BW64")) change(0, "RF64");
  if (head.starts_with("RIFF")) {
    for (const Chunk& chunk : chunks_of(source_.file, source_.size)) {
      const std::int64_t begin = chunk.place + 8;
      if (chunk.name != "data" || chunk.size != 0 || begin >= source_.size) continue;
      // Chunks that fill the rest: there is no sound indeed.
      const std::vector<Chunk> rest = chunks_of(source_.file, source_.size, begin);
      const bool filled =
          !rest.empty() &&
          rest.back().place + 8 + rest.back().size + rest.back().size % 2 >= source_.size;
      if (filled) break;
      const auto left =
          static_cast<std::uint32_t>(std::min<std::int64_t>(source_.size - begin, 0x7ffffffe));
      std::string size(4, '\0');
      for (std::size_t k = 0; k < 4; ++k) size[k] = static_cast<char>(left >> (8 * k) & 0xffU);
      change(chunk.place + 4, size);
      break;
    }
  }
  SF_VIRTUAL_IO io{};
  io.get_filelen = [](void* from) -> sf_count_t { return static_cast<Source*>(from)->size; };
  io.seek = [](sf_count_t offset, int whence, void* from) -> sf_count_t {
    Source& source = *static_cast<Source*>(from);
    source.file.clear();
    source.file.seekg(offset, whence == SEEK_SET   ? std::ios::beg
                              : whence == SEEK_CUR ? std::ios::cur
                                                   : std::ios::end);
    return source.file ? static_cast<sf_count_t>(source.file.tellg()) : -1;
  };
  io.read = [](void* to, sf_count_t count, void* from) -> sf_count_t {
    Source& source = *static_cast<Source*>(from);
    source.file.clear();
    const auto place = static_cast<std::int64_t>(source.file.tellg());
    source.file.read(static_cast<char*>(to), count);
    const auto got = static_cast<sf_count_t>(source.file.gcount());
    const auto last = source.changed.lower_bound(place + got);
    for (auto byte = source.changed.lower_bound(place); byte != last; ++byte) {
      static_cast<char*>(to)[byte->first - place] = byte->second;
    }
    source.file.clear();
    return got;
  };
  io.write = [](const void*, sf_count_t, void*) -> sf_count_t { return 0; };
  io.tell = [](void* from) -> sf_count_t {
    Source& source = *static_cast<Source*>(from);
    source.file.clear();
    return static_cast<sf_count_t>(source.file.tellg());
  };
  source_.file.clear();
  source_.file.seekg(0);
  // libsndfile finds some formats by the file's name, which it has of a path alone.
  *file_.put() = source_.changed.empty() ? sf_open(path.c_str(), SFM_READ, &info_)
                                         : sf_open_virtual(&io, SFM_READ, &info_, &source_);
  if (file_.get() == nullptr) refuse(path, source_.file, source_.size, sf_error(nullptr));
}

}  // namespace carillon::core
