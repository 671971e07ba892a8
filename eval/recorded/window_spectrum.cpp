#include "eval/recorded/window_spectrum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::eval::recorded {

namespace {

/// Harris 1978, table I: four terms, highest side lobe at -92 dB.
constexpr double terms[] = {0.35875, -0.48829, 0.14128, -0.01168};

double window(std::size_t n, std::size_t count) {
  double sum = 0;
  for (int term = 0; term < 4; ++term) {
    sum += terms[term] * std::cos(2 * std::numbers::pi * term * static_cast<double>(n) /
                                  static_cast<double>(count));
  }
  return sum;
}

SpectralPeak top(const WindowSpectrum& spectrum, std::size_t bin) {
  const double middle = spectrum.amplitudes[bin];
  const double before = spectrum.amplitudes[bin - 1], after = spectrum.amplitudes[bin + 1];
  if (!(before > 0 && after > 0)) return {static_cast<double>(bin) * spectrum.bin_width, middle};
  const double a = std::log(before), b = std::log(middle), c = std::log(after);
  const double shift = 0.5 * (a - c) / (a - 2 * b + c);
  return {(static_cast<double>(bin) + shift) * spectrum.bin_width,
          std::exp(b - 0.25 * (a - c) * shift)};
}

}  // namespace

WindowSpectrum window_spectrum(std::span<const double> samples, double sample_rate,
                               const Stretch& stretch) {
  if (stretch.end < stretch.first + 2 || !(sample_rate > 0)) {
    throw core::InputError(fmt::format("no spectrum of samples {} to {} at {} Hz", stretch.first,
                                       stretch.end, sample_rate));
  }
  const std::size_t count = stretch.end - stretch.first;
  synth::signal::RealFft fft(count);
  const std::span<double> signal = fft.signal();
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t place = stretch.first + n;
    const double sample = place < samples.size() ? samples[place] : 0;
    if (!std::isfinite(sample)) {
      throw core::InputError(fmt::format("sample {} is not finite", place));
    }
    signal[n] = sample * window(n, count);
  }
  fft.forward();
  WindowSpectrum spectrum;
  spectrum.bin_width = sample_rate / static_cast<double>(count);
  // The window's mean is its first term; half of a sinusoid lies at negative frequencies.
  const double scale = 2 / (terms[0] * static_cast<double>(count));
  for (const std::complex<double>& bin : fft.spectrum()) {
    spectrum.amplitudes.push_back(scale * std::abs(bin));
  }
  return spectrum;
}

std::vector<SpectralPeak> highest_peaks(const WindowSpectrum& spectrum, std::size_t count,
                                        double min_frequency) {
  std::vector<SpectralPeak> peaks;
  const auto& a = spectrum.amplitudes;
  for (std::size_t bin = 1; bin + 1 < a.size(); ++bin) {
    if (static_cast<double>(bin) * spectrum.bin_width < min_frequency) continue;
    if (a[bin] > a[bin - 1] && a[bin] > a[bin + 1]) peaks.push_back(top(spectrum, bin));
  }
  std::stable_sort(peaks.begin(), peaks.end(), [](const SpectralPeak& x, const SpectralPeak& y) {
    return x.amplitude > y.amplitude;
  });
  if (peaks.size() > count) peaks.resize(count);
  std::sort(peaks.begin(), peaks.end(),
            [](const SpectralPeak& x, const SpectralPeak& y) { return x.frequency < y.frequency; });
  return peaks;
}

}  // namespace carillon::eval::recorded
