#include "synth/recording/recording_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/hash.hpp"

namespace carillon::synth::recording {

namespace {

constexpr double silence = 1e-5;    // -100 dB of full scale: a tenth of 16 bits' smallest step
constexpr double silent_gap = 0.1;  // [s]
constexpr double step_s = 0.01;     // [s]
constexpr double shortest = 0.001;  // [s]
constexpr double lowest_rate = 1e3;
constexpr double highest_rate = 1e6;

}  // namespace

std::vector<std::filesystem::path> files_in_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  auto entry = std::filesystem::recursive_directory_iterator(folder, error);
  for (; !error && entry != std::filesystem::end(entry); entry.increment(error)) {
    const bool hidden = entry->path().filename().string().starts_with('.');
    std::error_code ignored;
    if (entry->is_directory(ignored)) {
      if (hidden) entry.disable_recursion_pending();
    } else if (!hidden) {
      files.push_back(entry->path().lexically_relative(folder));
    }
  }
  if (error) {
    throw core::InputError(
        fmt::format("{}: the folder cannot be read: {}", folder.string(), error.message()));
  }
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return a.generic_string() < b.generic_string(); });
  return files;
}

MonoRecording read_mono(const std::filesystem::path& path, int channel) {
  const core::AudioClip clip = core::read_audio(path);
  if (!(clip.sample_rate >= lowest_rate && clip.sample_rate <= highest_rate)) {
    throw core::InputError(
        fmt::format("a rate of {} Hz, not between 1 kHz and 1 MHz", clip.sample_rate));
  }
  if (channel > clip.channels) {
    throw core::InputError(fmt::format("no channel {}: it has {}", channel, clip.channels));
  }
  const auto channels = static_cast<std::size_t>(clip.channels);
  const std::size_t frames = clip.samples.size() / channels;
  if (static_cast<double>(frames) < shortest * clip.sample_rate) {
    throw core::InputError(fmt::format("{} samples, shorter than 1 ms", frames));
  }
  for (std::size_t i = 0; i < clip.samples.size(); ++i) {
    if (!std::isfinite(clip.samples[i])) {
      throw core::InputError(fmt::format("sample {} is not a finite number", i / channels));
    }
  }
  MonoRecording mono;
  mono.sample_rate = clip.sample_rate;
  mono.samples.resize(frames);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    const std::span all(clip.samples.data() + frame * channels, channels);
    double value = 0;
    for (const float sample : all) value += sample;
    mono.samples[frame] = channel > 0 ? all[static_cast<std::size_t>(channel - 1)]
                                      : static_cast<float>(value / static_cast<double>(channels));
  }
  return mono;
}

std::vector<Run> audible_runs(std::span<const float> samples, double sample_rate) {
  const auto step = std::max<std::size_t>(1, static_cast<std::size_t>(step_s * sample_rate));
  const auto gap = static_cast<std::size_t>(std::ceil(silent_gap * sample_rate));
  std::vector<Run> runs;
  for (std::size_t begin = 0; begin < samples.size(); begin += step) {
    const auto block = samples.subspan(begin, std::min(step, samples.size() - begin));
    const bool audible = std::any_of(block.begin(), block.end(),
                                     [](float sample) { return std::abs(sample) > silence; });
    if (!audible) continue;
    if (runs.empty() || begin - runs.back().end >= gap) runs.push_back({begin, begin});
    runs.back().end = begin + block.size();
  }
  return runs;
}

std::string content_of_files(const std::filesystem::path& path) {
  core::Sha256 hash;
  const auto add = [&hash](const std::filesystem::path& name, const std::filesystem::path& file) {
    hash.add(name.generic_string()).add(std::string_view("\n")).add(core::sha256_file(file));
  };
  if (std::filesystem::is_regular_file(path)) {
    add(path.filename(), path);
  } else {
    for (const auto& name : files_in_folder(path)) add(name, path / name);
  }
  return hash.hex();
}

std::string content_hash(const MonoRecording& recording) {
  return core::Sha256()
      .add(std::span(&recording.sample_rate, 1))
      .add(std::span<const float>(recording.samples))
      .hex();
}

}  // namespace carillon::synth::recording
