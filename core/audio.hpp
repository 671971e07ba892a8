#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace carillon::core {

/// Sound as it lies in a file: frames one after the other, channels interleaved.
struct AudioClip {
  std::vector<float> samples;
  int channels = 1;
  int sample_rate = 44100;
};

enum class SampleFormat { float32, int16 };

/// Full scale of 16 bits, as in libsndfile's reading; +1.0 itself clips by one step.
inline constexpr float int16_full_scale = 32768;

/// Samples at full scale 1.0, rounded, and clipped at full scale.
/// @param clipped  if given, how many were clipped is added
std::vector<std::int16_t> to_int16(std::span<const float> samples, std::int64_t* clipped = nullptr);

/// WAV file. float32 keeps every level; int16 is as of to_int16().
/// Equal samples give equal bytes (no time-stamped PEAK chunk).
/// @throws FileError
void write_wav(const std::filesystem::path& path, const AudioClip& clip, SampleFormat format);

/// The bytes of that file.
/// @param name  for messages
std::string wav_bytes(const std::string& name, const AudioClip& clip, SampleFormat format);

/// What a header says of an audio file; a damaged one may say anything.
struct AudioHeader {
  int channels = 1;
  int sample_rate = 44100;
  double seconds = 0;
};
/// @throws FileError  not readable, with the reason
AudioHeader read_audio_header(const std::filesystem::path& path);

/// Any format that libsndfile reads, as SoundFile has it.
/// @throws FileError  not readable, with the reason
AudioClip read_audio(const std::filesystem::path& path);

}  // namespace carillon::core
