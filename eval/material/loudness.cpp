#include "eval/material/loudness.hpp"

#include <algorithm>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "synth/modal/hearing.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::eval::material {

namespace {

constexpr double pi = std::numbers::pi;
/// Short against the decay of most modes, long enough to tell critical bands apart [s].
constexpr double window_length = 0.0232;
/// More frames would cost time and tell nothing new.
constexpr std::size_t max_frames = 400;
/// Zwicker's exponent of intensity.
constexpr double exponent = 0.23;

std::vector<double> hann(std::size_t size) {
  std::vector<double> window(size);
  for (std::size_t n = 0; n < size; ++n) {
    window[n] = 0.5 - 0.5 * std::cos(2 * pi * static_cast<double>(n) / static_cast<double>(size));
  }
  return window;
}

/// |X|^2 of one bin -> power, with the bin of negative frequency. The squares of a periodic Hann
/// window sum to 3/8 of its length.
double power_of_bin(const SpectrogramGrid& grid) {
  const auto size = static_cast<double>(grid.window);
  return 2 / (0.375 * size * size);
}

double frequency_at(double critical_band_rate) {
  double low = 0;
  double high = 1;
  while (synth::modal::bark(high) < critical_band_rate && high < 1e7) high *= 2;
  const auto error = [&](double f) { return synth::modal::bark(f) - critical_band_rate; };
  if (error(high) < 0) return high;
  std::uintmax_t steps = 100;
  const auto bracket = boost::math::tools::toms748_solve(
      error, low, high, boost::math::tools::eps_tolerance<double>(40), steps);
  return 0.5 * (bracket.first + bracket.second);
}

}  // namespace

SpectrogramGrid make_grid(std::size_t count, double sample_rate, double begin) {
  if (count == 0) throw core::InputError("a spectrogram of no samples");
  if (!(sample_rate > 0)) throw core::InputError("the sample rate must be positive");
  SpectrogramGrid grid;
  grid.sample_rate = sample_rate;
  grid.begin = begin;
  grid.window = synth::signal::good_fft_size(
      std::max<std::size_t>(16, static_cast<std::size_t>(window_length * sample_rate)));
  grid.hop = std::max(grid.window / 2, count / max_frames + 1);
  grid.frames = count > grid.window ? (count - grid.window) / grid.hop + 1 : 1;
  for (std::size_t k = 0; k <= grid.window / 2; ++k) {
    const double frequency =
        static_cast<double>(k) * sample_rate / static_cast<double>(grid.window);
    grid.band_of_bin.push_back(static_cast<std::size_t>(synth::modal::bark(frequency)));
  }
  grid.bands = grid.band_of_bin.back() + 1;
  return grid;
}

BandPowers band_powers(std::span<const double> samples, const SpectrogramGrid& grid) {
  const std::vector<double> window = hann(grid.window);
  const double factor = power_of_bin(grid);
  synth::signal::RealFft fft(grid.window);
  BandPowers powers(grid.frames * grid.bands);
  for (std::size_t m = 0; m < grid.frames; ++m) {
    for (std::size_t n = 0; n < grid.window; ++n) {
      const std::size_t at = m * grid.hop + n;
      fft.signal()[n] = at < samples.size() ? window[n] * samples[at] : 0;
    }
    fft.forward();
    for (std::size_t k = 0; k < fft.bins(); ++k) {
      powers[m * grid.bands + grid.band_of_bin[k]] += factor * std::norm(fft.spectrum()[k]);
    }
  }
  return powers;
}

BandPowers band_powers(std::span<const features::Feature> tones, const SpectrogramGrid& grid) {
  BandPowers powers(grid.frames * grid.bands);
  const std::size_t bins = grid.window / 2 + 1;
  // Hann's window moves a third of the spectrum by one bin either way: one more bin at both ends.
  std::vector<double> cosine(bins + 2);
  std::vector<double> sine(bins + 2);
  for (std::size_t k = 0; k < bins + 2; ++k) {
    const double angle = 2 * pi * (static_cast<double>(k) - 1) / static_cast<double>(grid.window);
    cosine[k] = std::cos(angle);
    sine[k] = std::sin(angle);
  }
  std::vector<double> real(bins + 2);
  std::vector<double> imag(bins + 2);
  std::vector<double> line(grid.bands);
  const auto size = static_cast<double>(grid.window);
  for (const features::Feature& tone : tones) {
    // Sum over the window of exp((-d + i (omega - omega_k)) n): (1 - q^N) / (1 - q exp(-i k)).
    const double decay = tone.decay_rate / grid.sample_rate;
    const double turn = 2 * pi * tone.frequency / grid.sample_rate;
    const std::complex<double> q = std::polar(std::exp(-decay), turn);
    const std::complex<double> top = 1.0 - std::polar(std::exp(-decay * size), turn * size);
    for (std::size_t k = 0; k < bins + 2; ++k) {
      const double a = 1 - (q.real() * cosine[k] + q.imag() * sine[k]);
      const double b = -(q.imag() * cosine[k] - q.real() * sine[k]);
      const double square = a * a + b * b;
      const bool on_bin = square < 1e-20;
      real[k] = on_bin ? size : (top.real() * a + top.imag() * b) / square;
      imag[k] = on_bin ? 0 : (top.imag() * a - top.real() * b) / square;
    }
    std::fill(line.begin(), line.end(), 0.0);
    for (std::size_t k = 0; k < bins; ++k) {
      const double x = 0.5 * real[k + 1] - 0.25 * (real[k] + real[k + 2]);
      const double y = 0.5 * imag[k + 1] - 0.25 * (imag[k] + imag[k + 2]);
      line[grid.band_of_bin[k]] += x * x + y * y;
    }
    // Half the amplitude belongs to the negative frequency.
    const double begun = 0.5 * tone.amplitude * std::exp(-tone.decay_rate * grid.begin);
    double level = power_of_bin(grid) * begun * begun;
    const double step = std::exp(-2 * decay * static_cast<double>(grid.hop));
    for (std::size_t m = 0; m < grid.frames && level > 0; ++m, level *= step) {
      double* frame = powers.data() + m * grid.bands;
      for (std::size_t z = 0; z < grid.bands; ++z) frame[z] += level * line[z];
    }
  }
  return powers;
}

std::vector<double> specific_loudness(const BandPowers& powers, const SpectrogramGrid& grid,
                                      const LoudnessScale& scale) {
  const double unit = std::pow(10, scale.unit_level / 10);
  std::vector<double> threshold(grid.bands);
  std::vector<double> height(grid.bands);
  for (std::size_t z = 0; z < grid.bands; ++z) {
    const double middle = frequency_at(static_cast<double>(z) + 0.5);
    threshold[z] = std::pow(10, std::min(300.0, synth::modal::hearing_threshold(middle)) / 10);
    height[z] = 0.08 * std::pow(threshold[z], exponent);
  }
  std::vector<double> loudness(powers.size());
  for (std::size_t i = 0; i < powers.size(); ++i) {
    const std::size_t z = i % grid.bands;
    const double background = scale.background.empty() ? 0 : scale.background[z];
    const double excitation = unit * (powers[i] + background) / threshold[z];
    if (excitation > 1) {
      loudness[i] = height[z] * (std::pow(0.5 + 0.5 * excitation, exponent) - 1);
    }
  }
  return loudness;
}

}  // namespace carillon::eval::material
