#include "synth/motion/slow_rates.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "synth/modal_response.hpp"
#include "synth/real_fft.hpp"

namespace carillon::synth {

namespace {

constexpr double kLowest = 20;  ///< [Hz]
/// Silence between the force's end and its begin, which a transform joins [samples].
constexpr std::size_t kApart = 4096;

}  // namespace

std::size_t octave_of(double eigenvalue) {
  const double frequency = std::sqrt(eigenvalue) / (2 * std::numbers::pi);
  const double octave = std::floor(std::log2(std::max(frequency, kLowest) / kLowest));
  return static_cast<std::size_t>(std::min(octave, static_cast<double>(kModeOctaves - 1)));
}

std::vector<Eigen::Matrix3Xf> slow_rates(const Eigen::Matrix3Xd& force, double sample_rate,
                                         const std::vector<bool>& octaves) {
  std::vector<Eigen::Matrix3Xf> rates(kModeOctaves);
  const auto count = static_cast<std::size_t>(force.cols());
  if (count == 0 || force.isZero(0)) return rates;
  RealFft fft(good_fft_size(count + kApart));
  const double turn = 2 * std::numbers::pi * sample_rate / static_cast<double>(fft.size());
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    std::fill(fft.signal().begin(), fft.signal().end(), 0.0);
    for (std::size_t n = 0; n < count; ++n) {
      fft.signal()[n] = force(axis, static_cast<Eigen::Index>(n));
    }
    fft.forward();
    const std::vector<std::complex<double>> spectrum(fft.spectrum().begin(), fft.spectrum().end());
    for (std::size_t octave = 0; octave < kModeOctaves; ++octave) {
      if (!octaves[octave]) continue;
      // The middle of the octave.
      const double omega =
          2 * std::numbers::pi * kLowest * std::exp2(static_cast<double>(octave) + 0.5);
      fft.spectrum()[0] = 0;
      for (std::size_t bin = 1; bin < spectrum.size(); ++bin) {
        const double at = turn * static_cast<double>(bin);
        fft.spectrum()[bin] =
            std::complex<double>(0, at * slow_share(omega, 2 * std::numbers::pi / at)) *
            spectrum[bin];
      }
      fft.inverse();
      Eigen::Matrix3Xf& rate = rates[octave];
      if (rate.cols() == 0) rate.setZero(3, force.cols());
      for (std::size_t n = 0; n < count; ++n) {
        rate(axis, static_cast<Eigen::Index>(n)) = static_cast<float>(fft.signal()[n]);
      }
    }
  }
  return rates;
}

}  // namespace carillon::synth
