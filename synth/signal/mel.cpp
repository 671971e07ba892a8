#include "synth/signal/mel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::synth::signal {

namespace {

/// Slaney's scale (Auditory Toolbox, 1998): linear below 1 kHz, 27 bands per factor 6.4 above.
constexpr double linear_step = 200.0 / 3.0;  // [Hz]
constexpr double break_frequency = 1000;     // [Hz]
constexpr double break_mel = break_frequency / linear_step;
const double log_step = std::log(6.4) / 27;

double mel_of(double frequency) {
  return frequency < break_frequency ? frequency / linear_step
                                     : break_mel + std::log(frequency / break_frequency) / log_step;
}

double frequency_of(double mel) {
  return mel < break_mel ? mel * linear_step
                         : break_frequency * std::exp((mel - break_mel) * log_step);
}

MelOptions checked(MelOptions options) {
  if (!(options.sample_rate > 0) || !std::isfinite(options.sample_rate)) {
    throw core::InputError(
        fmt::format("mel: sample rate must be positive, not {} Hz", options.sample_rate));
  }
  if (options.fft_size < 2 || options.fft_size % 2 != 0) {
    throw core::InputError(
        fmt::format("mel: FFT size must be even and at least 2, not {}", options.fft_size));
  }
  if (options.hop < 1) {
    throw core::InputError(fmt::format("mel: hop must be at least 1, not {}", options.hop));
  }
  if (options.bands < 1) {
    throw core::InputError(fmt::format("mel: bands must be at least 1, not {}", options.bands));
  }
  if (options.bands > options.fft_size / 2 + 1) {
    throw core::InputError(fmt::format("mel: {} bands are more than the {} bins of an FFT of {}",
                                       options.bands, options.fft_size / 2 + 1, options.fft_size),
                           "ask for fewer bands or a larger FFT");
  }
  const double nyquist = options.sample_rate / 2;
  if (options.max_frequency == 0) options.max_frequency = nyquist;
  if (!(options.min_frequency >= 0 && options.min_frequency < options.max_frequency &&
        options.max_frequency <= nyquist)) {
    throw core::InputError(
        fmt::format("mel: band limits {} to {} Hz must rise and lie within 0 to {} Hz",
                    options.min_frequency, options.max_frequency, nyquist));
  }
  return options;
}

std::vector<float> mel_filters(const MelOptions& options) {
  const auto bands = static_cast<std::size_t>(options.bands);
  const auto bins = static_cast<std::size_t>(options.fft_size / 2 + 1);
  const double low = mel_of(options.min_frequency);
  const double high = mel_of(options.max_frequency);
  std::vector<double> edge(bands + 2);
  for (std::size_t i = 0; i < edge.size(); ++i) {
    edge[i] =
        frequency_of(low + (high - low) * static_cast<double>(i) / static_cast<double>(bands + 1));
  }
  // Exactly, or the bin at Nyquist would have a weight of one rounding error.
  edge.front() = options.min_frequency;
  edge.back() = options.max_frequency;
  std::vector<float> filters(bands * bins);
  for (std::size_t band = 0; band < bands; ++band) {
    const double area_norm = 2 / (edge[band + 2] - edge[band]);
    for (std::size_t bin = 0; bin < bins; ++bin) {
      const double frequency = static_cast<double>(bin) * options.sample_rate / options.fft_size;
      const double rise = (frequency - edge[band]) / (edge[band + 1] - edge[band]);
      const double fall = (edge[band + 2] - frequency) / (edge[band + 2] - edge[band + 1]);
      // librosa rounds the triangle and then the product: the same two roundings.
      const auto triangle = static_cast<float>(std::max(0.0, std::min(rise, fall)));
      filters[band * bins + bin] = static_cast<float>(static_cast<double>(triangle) * area_norm);
    }
  }
  return filters;
}

}  // namespace

int mel_frames(std::size_t count, const MelOptions& options) {
  return 1 + static_cast<int>(count / static_cast<std::size_t>(checked(options).hop));
}

MelSpectrogram::MelSpectrogram(const MelOptions& options)
    : options_(checked(options)),
      filters_(mel_filters(options_)),
      fft_(static_cast<std::size_t>(options_.fft_size)) {
  const auto size = static_cast<std::size_t>(options_.fft_size);
  const std::size_t bins = size / 2 + 1;
  for (std::size_t first = 0; first < filters_.size(); first += bins) {
    std::size_t begin = first, end = first + bins;
    while (begin < end && filters_[begin] == 0) ++begin;
    while (end > begin && filters_[end - 1] == 0) --end;
    within_.push_back({begin - first, end - first});
  }
  window_.resize(size);
  for (std::size_t i = 0; i < size; ++i) {
    // Periodic Hann: its period is the window's length.
    window_[i] =
        0.5 *
        (1 - std::cos(2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(size)));
  }
}

std::vector<float> MelSpectrogram::operator()(std::span<const float> clip) const {
  const auto size = static_cast<std::size_t>(options_.fft_size);
  const std::size_t bins = size / 2 + 1;
  const auto bands = static_cast<std::size_t>(options_.bands);
  const auto frames = static_cast<std::size_t>(mel_frames(clip.size(), options_));
  const std::span<double> signal = fft_.signal();
  const std::span<const std::complex<double>> spectrum = fft_.spectrum();
  std::vector<float> result(bands * frames);
  std::vector<double> power(bins);
  for (std::size_t frame = 0; frame < frames; ++frame) {
    // Frames are centred on multiples of the hop; outside the clip there is silence.
    const std::size_t centre = frame * static_cast<std::size_t>(options_.hop);
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t shifted = centre + i;
      const bool inside = shifted >= size / 2 && shifted - size / 2 < clip.size();
      signal[i] = inside ? window_[i] * static_cast<double>(clip[shifted - size / 2]) : 0.0;
    }
    fft_.forward();
    for (std::size_t bin = 0; bin < bins; ++bin) {
      power[bin] = std::norm(spectrum[bin]);
    }
    for (std::size_t band = 0; band < bands; ++band) {
      double sum = 0;
      for (std::size_t bin = within_[band][0]; bin < within_[band][1]; ++bin) {
        sum += static_cast<double>(filters_[band * bins + bin]) * power[bin];
      }
      result[band * frames + frame] = static_cast<float>(sum);
    }
  }
  return result;
}

}  // namespace carillon::synth::signal
