#pragma once

#include <sndfile.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <stdexcept>
#include <vector>

namespace carillon::synth {

/// A sound file of any of libsndfile's formats, e.g. SF_FORMAT_WAV | SF_FORMAT_PCM_24. Samples of
/// all channels frame by frame.
inline void write_sound(const std::filesystem::path& path, const std::vector<double>& samples,
                        int rate, int channels = 1, int format = SF_FORMAT_WAV | SF_FORMAT_FLOAT) {
  SF_INFO info{};
  info.samplerate = rate;
  info.channels = channels;
  info.format = format;
  SNDFILE* file = sf_open(path.c_str(), SFM_WRITE, &info);
  if (file == nullptr) throw std::runtime_error(sf_strerror(nullptr));
  sf_command(file, SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
  sf_write_double(file, samples.data(), static_cast<sf_count_t>(samples.size()));
  sf_close(file);
}

/// White noise of the standard library's, root mean square 0.1.
inline std::vector<double> some_noise(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 0.1);
  std::vector<double> samples(count);
  for (double& sample : samples) sample = normal(random);
  return samples;
}

inline std::vector<double> sine(std::size_t count, double frequency, double rate,
                                double amplitude = 0.5) {
  std::vector<double> samples(count);
  for (std::size_t i = 0; i < count; ++i) {
    samples[i] = amplitude *
                 std::sin(2 * std::numbers::pi * frequency * static_cast<double>(i) / rate + 0.3);
  }
  return samples;
}

}  // namespace carillon::synth
