#include "eval/perception/spectral_distance.hpp"

#include <fmt/format.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "core/error.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::eval::perception {

namespace {

struct Resolution {
  std::size_t transform;
  std::size_t hop;
  std::size_t window;
};
constexpr Resolution resolutions[] = {{1024, 120, 600}, {2048, 240, 1200}, {512, 50, 240}};
constexpr double min_power = 1e-7;

/// Place of a sample in a signal that is mirrored at its first and last samples, again and again.
std::size_t mirrored(std::ptrdiff_t at, std::size_t count) {
  if (count == 1) return 0;
  const auto period = static_cast<std::ptrdiff_t>(2 * (count - 1));
  at = ((at % period) + period) % period;
  return static_cast<std::size_t>(std::min(at, period - at));
}

/// Short-time magnitudes, one frame after the other.
class Magnitudes {
 public:
  explicit Magnitudes(const Resolution& resolution)
      : resolution_(resolution), fft_(resolution.transform), window_(resolution.window) {
    const auto size = static_cast<double>(window_.size());
    for (std::size_t n = 0; n < window_.size(); ++n) {
      window_[n] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(n) / size);
    }
  }

  const std::vector<double>& of_frame(std::span<const double> samples, std::size_t frame) {
    const auto begin = static_cast<std::ptrdiff_t>(frame * resolution_.hop) -
                       static_cast<std::ptrdiff_t>(resolution_.window / 2);
    // Where the window lies in the transform changes phases alone.
    for (std::size_t n = 0; n < fft_.size(); ++n) {
      fft_.signal()[n] =
          n < window_.size()
              ? window_[n] *
                    samples[mirrored(begin + static_cast<std::ptrdiff_t>(n), samples.size())]
              : 0;
    }
    fft_.forward();
    values_.resize(fft_.bins());
    for (std::size_t k = 0; k < values_.size(); ++k) {
      values_[k] = std::sqrt(std::max(min_power, std::norm(fft_.spectrum()[k])));
    }
    return values_;
  }

 private:
  Resolution resolution_;
  synth::signal::RealFft fft_;
  std::vector<double> window_;
  std::vector<double> values_;
};

SpectralDistance distance_at(const Resolution& resolution, std::span<const double> reference,
                             std::span<const double> other) {
  Magnitudes of_reference(resolution), of_other(resolution);
  double squares = 0, all = 0, logarithms = 0, count = 0;
  for (std::size_t frame = 0; frame * resolution.hop <= reference.size(); ++frame) {
    const std::vector<double>& x = of_reference.of_frame(reference, frame);
    const std::vector<double>& y = of_other.of_frame(other, frame);
    for (std::size_t k = 0; k < x.size(); ++k) {
      squares += (x[k] - y[k]) * (x[k] - y[k]);
      all += x[k] * x[k];
      logarithms += std::abs(std::log(x[k] / y[k]));
    }
    count += static_cast<double>(x.size());
  }
  return {std::sqrt(squares / all), logarithms / count};
}

}  // namespace

SpectralDistance spectral_distance(std::span<const double> reference,
                                   std::span<const double> other) {
  if (reference.empty() || reference.size() != other.size()) {
    throw core::InputError(fmt::format("spectra of {} and of {} samples cannot be compared",
                                       reference.size(), other.size()));
  }
  SpectralDistance mean;
  for (const Resolution& resolution : resolutions) {
    const SpectralDistance one = distance_at(resolution, reference, other);
    mean.convergence += one.convergence / std::size(resolutions);
    mean.log_magnitude += one.log_magnitude / std::size(resolutions);
  }
  return mean;
}

}  // namespace carillon::eval::perception
