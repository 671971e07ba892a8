#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace carillon::synth::recording {

/// Samples [begin, end) of a recording.
struct Run {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t size() const { return end - begin; }
};

/// One channel of a recording, or the mean of all.
struct MonoRecording {
  std::vector<float> samples;
  double sample_rate = 0;  ///< [Hz]
};

/// Files in a folder and its folders, those whose names begin with a dot left out, relative to it
/// and in the order of their names.
/// @throws InputError  the folder cannot be read
std::vector<std::filesystem::path> files_in_folder(const std::filesystem::path& folder);

/// @param channel  1, 2, ...; 0: mean of all
/// @throws FileError   not readable
/// @throws InputError  what is wrong with it: no such channel, a sample that is not finite, a rate
///                     out of range, shorter than 1 ms
MonoRecording read_mono(const std::filesystem::path& path, int channel);

/// What lies between silent stretches: 0.1 s or more without a sample above -100 dB of full scale,
/// found in steps of 10 ms.
std::vector<Run> audible_runs(std::span<const float> samples, double sample_rate);

/// SHA-256 of a folder's files and of their names, or of one file and its name.
/// @throws InputError  the folder cannot be read
/// @throws FileError   a file cannot be read
std::string content_of_files(const std::filesystem::path& path);

/// SHA-256 of the rate and the samples.
std::string content_hash(const MonoRecording& recording);

}  // namespace carillon::synth::recording
