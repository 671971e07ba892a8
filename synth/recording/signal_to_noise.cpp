#include "synth/recording/signal_to_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace carillon::synth::recording {

namespace {

constexpr double smoothing = 0.01;  // [s]
constexpr double range = 1e-6;      // 60 dB in energy

std::size_t samples_per_row(std::size_t size, std::size_t rows) {
  if (rows == 0 || size % rows != 0) {
    throw core::InputError(fmt::format("{} samples are not {} rows of equal length", size, rows));
  }
  return size / rows;
}

std::vector<double> energy_of(std::span<const float> clip, std::size_t rows) {
  const std::size_t count = samples_per_row(clip.size(), rows);
  std::vector<double> energy(count, 0.0);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t i = 0; i < count; ++i) {
      const double value = clip[row * count + i];
      if (!std::isfinite(value)) {
        throw core::InputError(
            fmt::format("signal-to-noise ratio: sample {} is not finite", row * count + i));
      }
      energy[i] += value * value;
    }
  }
  return energy;
}

/// Sums of the window that begins at each value. Block by block, as a window is the end of one
/// block and the beginning of the next: so nothing is ever subtracted, which would leave roundings
/// of the loud beginning in the quiet end.
std::vector<double> sums_ahead(const std::vector<double>& values, std::size_t window) {
  const std::size_t count = values.size();
  std::vector<double> sums(count), from_begin(count);
  for (std::size_t begin = 0; begin < count; begin += window) {
    const std::size_t end = std::min(begin + window, count);
    double sum = 0;
    for (std::size_t i = end; i-- > begin;) sums[i] = sum += values[i];
    sum = 0;
    for (std::size_t i = begin; i < end; ++i) from_begin[i] = sum += values[i];
    // Windows that begin in the block before and end in this one.
    if (begin == 0) continue;
    for (std::size_t i = begin - window + 1; i < begin; ++i) {
      sums[i] += from_begin[std::min(i + window, count) - 1];
    }
  }
  return sums;
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
  while (energy[part.begin] < range * loudest) ++part.begin;

  const std::size_t count = energy.size();
  const double wide =
      std::clamp(std::round(smoothing * sample_rate), 1.0, static_cast<double>(count));
  const std::vector<double> sums = sums_ahead(energy, static_cast<std::size_t>(wide));
  const double highest = *std::max_element(sums.begin(), sums.end());
  part.end = count;
  while (part.end > part.begin + 1 && sums[part.end - 1] < range * highest) --part.end;
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

}  // namespace carillon::synth::recording
