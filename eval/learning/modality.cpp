#include "eval/learning/modality.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "synth/signal/resample.hpp"

namespace carillon::eval::learning {

std::string_view name_of(Modality modality) {
  switch (modality) {
    case Modality::spectrogram:
      return "spectrogram";
    case Modality::waveform:
      return "waveform";
    case Modality::voxels:
      return "voxels";
    case Modality::image:
      return "image";
    case Modality::touch:
      return "touch";
  }
  return "";
}

std::string_view name_of(SpectrogramScale scale) {
  return scale == SpectrogramScale::decibels ? "decibels" : "power";
}

void SpectrogramInput::apply(std::span<float> relative) const {
  if (scale == SpectrogramScale::power) return;
  for (float& value : relative) {
    const double below = value > 0 ? core::decibels(static_cast<double>(value)) : -1e9;
    value = static_cast<float>(std::max(0.0, 1 + below / range));
  }
}

std::size_t values_in(const ModalityExtent& extent) {
  return static_cast<std::size_t>(
      std::accumulate(extent.begin(), extent.end(), std::int64_t{1}, std::multiplies<>()));
}

namespace prepare {

namespace {

void require_finite(std::span<const float> values, const char* what) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    throw core::InputError(fmt::format("{} holds {} (value {})", what, values[i], i));
  }
}

}  // namespace

bool spectrogram(std::span<float> power) {
  require_finite(power, "the spectrogram");
  const float largest = power.empty() ? 0 : *std::max_element(power.begin(), power.end());
  if (!(largest > 0)) {
    std::fill(power.begin(), power.end(), 0.0F);
    return false;
  }
  for (float& value : power) {
    value = static_cast<float>(std::max(0.0, static_cast<double>(value) / largest));
  }
  return true;
}

std::vector<float> waveform(std::span<const float> clip, double sample_rate) {
  require_finite(clip, "the clip");
  const std::vector<double> samples(clip.begin(), clip.end());
  const std::vector<double> slower =
      synth::signal::resample(samples, sample_rate, prepare::waveform_rate);
  double largest = 0;
  for (const double value : slower) largest = std::max(largest, std::abs(value));
  std::vector<float> prepared(slower.size());
  if (largest == 0) return prepared;
  for (std::size_t i = 0; i < slower.size(); ++i) {
    prepared[i] = static_cast<float>(slower[i] / largest);
  }
  return prepared;
}

void image(std::span<const std::uint8_t> pixels, std::size_t height, std::size_t width,
           std::span<float> planes) {
  for (std::size_t y = 0; y < prepare::image_side; ++y) {
    const std::size_t top = y * height / prepare::image_side;
    const std::size_t bottom = std::max(top + 1, (y + 1) * height / prepare::image_side);
    for (std::size_t x = 0; x < prepare::image_side; ++x) {
      const std::size_t left = x * width / prepare::image_side;
      const std::size_t right = std::max(left + 1, (x + 1) * width / prepare::image_side);
      std::uint64_t sums[3] = {0, 0, 0};
      for (std::size_t row = top; row < bottom; ++row) {
        for (std::size_t column = left; column < right; ++column) {
          for (std::size_t c = 0; c < 3; ++c) sums[c] += pixels[(row * width + column) * 3 + c];
        }
      }
      const double count = 255.0 * static_cast<double>((bottom - top) * (right - left));
      for (std::size_t c = 0; c < 3; ++c) {
        planes[(c * prepare::image_side + y) * prepare::image_side + x] =
            static_cast<float>(static_cast<double>(sums[c]) / count);
      }
    }
  }
}

void touch(std::span<const float> force, std::span<float> planes) {
  require_finite(force, "the force of touch");
  double square = 0;
  for (const float value : force) square += static_cast<double>(value) * value;
  const std::size_t ticks = force.size() / 3;
  const double scale = square > 0 ? std::sqrt(static_cast<double>(force.size()) / square) : 0;
  for (std::size_t tick = 0; tick < ticks; ++tick) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      planes[axis * ticks + tick] = static_cast<float>(scale * force[tick * 3 + axis]);
    }
  }
}

}  // namespace prepare
}  // namespace carillon::eval::learning
