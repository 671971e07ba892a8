#include "synth/signal_to_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::synth {

namespace {

constexpr double kSmoothing = 0.01;  // [s]
constexpr double kRange = 1e-6;      // 60 dB in energy

std::size_t samples_per_row(std::size_t size, std::size_t rows) {
  if (rows == 0 || size % rows != 0) {
    throw core::InputError(fmt::format("{} samples are not {} rows of equal length", size, rows));
  }
  return size / rows;
}

std::vector<double> energy_of(std::span<const float> clip, std::size_t rows) {
  const std::size_t count = samples_per_row(clip.size(), rows);
  std::vector<double> energy(count, 0.0);
  for (std::size_t i = 0; i < clip.size(); ++i) {
    const double value = clip[i];
    if (!std::isfinite(value)) {
      throw core::InputError(fmt::format("signal-to-noise ratio: sample {} is not finite", i));
    }
    energy[i % count] += value * value;
  }
  return energy;
}

template <class T>
double power_of(std::span<const T> clip, std::size_t rows, const ActivePart& part) {
  const std::size_t count = samples_per_row(clip.size(), rows);
  if (part.empty()) return 0;
  if (part.end > count) {
    throw core::InputError(
        fmt::format("samples {} to {} of a clip of {}", part.begin, part.end, count));
  }
  double sum = 0;
  for (std::size_t row = 0; row < rows; ++row) {
    for (const T sample : clip.subspan(row * count + part.begin, part.size())) {
      const double value = sample;
      sum += value * value;
    }
  }
  return sum / static_cast<double>(rows * part.size());
}

}  // namespace

ActivePart active_part(std::span<const float> clip, std::size_t rows, double sample_rate) {
  if (!(sample_rate > 0) || !std::isfinite(sample_rate)) {
    throw core::InputError(fmt::format("active part: a sample rate of {} Hz", sample_rate));
  }
  const std::vector<double> energy = energy_of(clip, rows);
  const double loudest = energy.empty() ? 0 : *std::max_element(energy.begin(), energy.end());
  if (!(loudest > 0)) return {};
  ActivePart part;
  while (energy[part.begin] < kRange * loudest) ++part.begin;

  // Sums over the window that begins at each sample, from the end backwards. Taken block by block
  // (a window is the end of one block and the beginning of the next) nothing is ever subtracted,
  // which would leave roundings of the loud beginning in the quiet end.
  const std::size_t count = energy.size();
  const double wide =
      std::clamp(std::round(kSmoothing * sample_rate), 1.0, static_cast<double>(count));
  const auto window = static_cast<std::size_t>(wide);
  std::vector<double> to_block_end(count), from_block_begin(count);
  for (std::size_t i = count; i-- > 0;) {
    const bool last = (i + 1) % window == 0 || i + 1 == count;
    to_block_end[i] = energy[i] + (last ? 0 : to_block_end[i + 1]);
  }
  for (std::size_t i = 0; i < count; ++i) {
    from_block_begin[i] = energy[i] + (i % window == 0 ? 0 : from_block_begin[i - 1]);
  }
  const auto smoothed = [&](std::size_t i) {
    // A window within one block ends where the block ends.
    const std::size_t last = std::min(i + window, count) - 1;
    const bool one_block = i / window == last / window;
    return to_block_end[i] + (one_block ? 0 : from_block_begin[last]);
  };
  double highest = 0;
  for (std::size_t i = 0; i < count; ++i) highest = std::max(highest, smoothed(i));
  part.end = count;
  while (part.end > part.begin + 1 && smoothed(part.end - 1) < kRange * highest) --part.end;
  return part;
}

double mean_power(std::span<const float> clip, std::size_t rows, const ActivePart& part) {
  return power_of(clip, rows, part);
}

double mean_power(std::span<const double> clip, std::size_t rows, const ActivePart& part) {
  return power_of(clip, rows, part);
}

double add_noise(std::span<float> clip, std::span<const double> noise, std::size_t rows,
                 const ActivePart& part, double decibels) {
  if (clip.size() != noise.size()) {
    throw core::InputError(
        fmt::format("noise of {} samples for a clip of {}", noise.size(), clip.size()));
  }
  const double signal_power = mean_power(std::span<const float>(clip), rows, part);
  const double noise_power = mean_power(noise, rows, part);
  if (!(signal_power > 0)) {
    throw core::InputError("a silent clip has no signal-to-noise ratio");
  }
  if (!(noise_power > 0) || !std::isfinite(noise_power)) {
    throw core::InputError("the noise is silent, or not finite, where the sound is");
  }
  const double factor = std::sqrt(signal_power / noise_power) * std::pow(10.0, -decibels / 20);
  // Checked before anything is written, so that a clip is never left half mixed.
  for (std::size_t i = 0; i < clip.size(); ++i) {
    if (!std::isfinite(static_cast<float>(clip[i] + factor * noise[i]))) {
      throw core::InputError(
          fmt::format("noise at {} dB goes beyond what single precision holds", decibels));
    }
  }
  for (std::size_t i = 0; i < clip.size(); ++i) {
    clip[i] = static_cast<float>(clip[i] + factor * noise[i]);
  }
  return factor;
}

}  // namespace carillon::synth
