#include "synth/signal/mel.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

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

constexpr int max_bands = 1 << 16;

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
  if (options.bands > max_bands) {
    throw core::InputError(fmt::format("mel: {} bands are more than {}", options.bands, max_bands),
                           "ask for fewer bands");
  }
  if (options.resized_bands < 0 || options.resized_bands > options.bands ||
      options.resized_frames < 0) {
    throw core::InputError(fmt::format("mel: {} bands cannot be made smaller to {}", options.bands,
                                       options.resized_bands));
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

/// Edges of the bands' triangles [Hz]: band b rises from b to b + 1 and falls to b + 2.
std::vector<double> band_edges(const MelOptions& options) {
  const auto bands = static_cast<std::size_t>(options.bands);
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
  return edge;
}

int empty_bands(const MelOptions& options) {
  const std::vector<double> edge = band_edges(options);
  const double step = options.sample_rate / options.fft_size;
  int empty = 0;
  for (std::size_t band = 0; band + 2 < edge.size(); ++band) {
    // The first bin above the triangle's lower end.
    const double bin = std::floor(edge[band] / step) + 1;
    if (!(bin * step < edge[band + 2])) ++empty;
  }
  return empty;
}

MelOptions resolved(MelOptions options) {
  options = checked(options);
  if (const int empty = empty_bands(options); empty > 0) {
    throw core::InputError(fmt::format("mel: {} of {} bands hold no bin of an FFT of {}", empty,
                                       options.bands, options.fft_size),
                           resolved_mel_bands(options));
  }
  return options;
}

std::vector<float> mel_filters(const MelOptions& options) {
  const auto bands = static_cast<std::size_t>(options.bands);
  const auto bins = static_cast<std::size_t>(options.fft_size / 2 + 1);
  const std::vector<double> edge = band_edges(options);
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

/// Weights with which cells become fewer, each the mean of what it covers: of each new cell the
/// first old one, and what it has of that and the following ones.
struct Covered {
  std::size_t first = 0;
  std::vector<double> weights;  ///< their sum is 1
};
std::vector<Covered> covered_cells(std::size_t cells, std::size_t fewer) {
  std::vector<Covered> all(fewer);
  const double width = static_cast<double>(cells) / static_cast<double>(fewer);
  for (std::size_t i = 0; i < fewer; ++i) {
    const double begin = static_cast<double>(i) * width, end = begin + width;
    all[i].first = static_cast<std::size_t>(begin);
    for (std::size_t cell = all[i].first; cell < cells && static_cast<double>(cell) < end; ++cell) {
      const double from = std::max(begin, static_cast<double>(cell));
      const double to = std::min(end, static_cast<double>(cell + 1));
      all[i].weights.push_back((to - from) / width);
    }
  }
  return all;
}

std::vector<float> resized(std::span<const float> cells, std::size_t frames, MelExtent to) {
  const std::vector<Covered> rows =
      covered_cells(cells.size() / frames, static_cast<std::size_t>(to.bands));
  const std::vector<Covered> columns = covered_cells(frames, static_cast<std::size_t>(to.frames));
  std::vector<float> fewer;
  for (const Covered& row : rows) {
    for (const Covered& column : columns) {
      double mean = 0;
      for (std::size_t r = 0; r < row.weights.size(); ++r) {
        for (std::size_t c = 0; c < column.weights.size(); ++c) {
          mean += row.weights[r] * column.weights[c] *
                  static_cast<double>(cells[(row.first + r) * frames + column.first + c]);
        }
      }
      fewer.push_back(static_cast<float>(mean));
    }
  }
  return fewer;
}

/// Of what each of so many covers; 0: the values themselves.
std::vector<double> means_of(const std::vector<double>& values, int fewer) {
  if (fewer == 0) return values;
  std::vector<double> means;
  for (const Covered& covered : covered_cells(values.size(), static_cast<std::size_t>(fewer))) {
    means.push_back(std::inner_product(covered.weights.begin(), covered.weights.end(),
                                       values.begin() + static_cast<std::ptrdiff_t>(covered.first),
                                       0.0));
  }
  return means;
}

int computed_frames(std::size_t count, const MelOptions& options) {
  return 1 + static_cast<int>(count / static_cast<std::size_t>(options.hop));
}

}  // namespace

MelExtent mel_extent(std::size_t count, const MelOptions& options) {
  const int frames = computed_frames(count, checked(options));
  if (options.resized_frames > frames) {
    throw core::InputError(
        fmt::format("mel: {} frames cannot be made smaller to {}", frames, options.resized_frames),
        "a shorter hop, or a longer clip, has more");
  }
  return {options.resized_bands > 0 ? options.resized_bands : options.bands,
          options.resized_frames > 0 ? options.resized_frames : frames};
}

std::vector<double> mel_band_centers(const MelOptions& options) {
  const std::vector<double> edge = band_edges(checked(options));
  return means_of({edge.begin() + 1, edge.end() - 1}, options.resized_bands);
}

std::vector<double> mel_frame_centers(std::size_t count, const MelOptions& options) {
  mel_extent(count, options);
  std::vector<double> middles;
  for (int frame = 0; frame < computed_frames(count, options); ++frame)
    middles.push_back(frame * options.hop / options.sample_rate);
  return means_of(middles, options.resized_frames);
}

int empty_mel_bands(const MelOptions& options) {
  return empty_bands(checked(options));
}

std::string resolved_mel_bands(const MelOptions& options) {
  constexpr int largest_fft = 1 << 20;
  MelOptions fewer = checked(options), finer = fewer;
  int resolves = 0;
  for (int too_many = fewer.bands + 1; too_many - resolves > 1;) {
    fewer.bands = (resolves + too_many) / 2;
    (empty_bands(fewer) == 0 ? resolves : too_many) = fewer.bands;
  }
  finer.fft_size = 2;
  while (finer.fft_size < largest_fft && empty_bands(finer) > 0) finer.fft_size *= 2;
  std::vector<std::string> remedies;
  if (resolves > 0) remedies.push_back(fmt::format("at most {} bands", resolves));
  if (empty_bands(finer) == 0) remedies.push_back(fmt::format("an FFT of {}", finer.fft_size));
  if (remedies.empty()) return "a wider range of frequencies";
  return fmt::format("{}", fmt::join(remedies, ", or "));
}

MelSpectrogram::MelSpectrogram(const MelOptions& options)
    : options_(resolved(options)),
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
  const MelExtent extent = mel_extent(clip.size(), options_);
  const auto frames = static_cast<std::size_t>(computed_frames(clip.size(), options_));
  std::vector<float> cells = computed(clip, frames);
  if (extent.bands == options_.bands && extent.frames == static_cast<int>(frames)) return cells;
  return resized(cells, frames, extent);
}

std::vector<float> MelSpectrogram::computed(std::span<const float> clip, std::size_t frames) const {
  const auto size = static_cast<std::size_t>(options_.fft_size);
  const std::size_t bins = size / 2 + 1;
  const auto bands = static_cast<std::size_t>(options_.bands);
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
