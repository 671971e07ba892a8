#include "synth/motion/detail/slow_rates.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "synth/modal/modal_response.hpp"
#include "synth/signal/real_fft.hpp"

namespace carillon::synth::motion {

namespace {

constexpr double lowest_frequency = 20;  ///< [Hz]
/// Periods of an octave after which its filter's response is over: its slowest poles decay by
/// exp(-2 pi sin(pi / 16)) = 0.29 a period.
constexpr double reach_factor = 6;

}  // namespace

std::size_t octave_of(double eigenvalue) {
  const double frequency = std::sqrt(eigenvalue) / (2 * std::numbers::pi);
  const double octave =
      std::floor(std::log2(std::max(frequency, lowest_frequency) / lowest_frequency));
  return static_cast<std::size_t>(std::min(octave, static_cast<double>(mode_octaves - 1)));
}

std::vector<Eigen::Matrix3Xf> slow_rates(const Eigen::Matrix3Xd& force, double sample_rate,
                                         const std::vector<bool>& octaves) {
  std::vector<Eigen::Matrix3Xf> rates(mode_octaves);
  // Contacts rest most of the time: the part that is not silent, and as far as filters reach.
  Eigen::Index begin = 0, end = force.cols();
  while (begin < end && force.col(begin).isZero(0)) ++begin;
  while (end > begin && force.col(end - 1).isZero(0)) --end;
  if (begin == end) return rates;
  const auto lowest = std::find(octaves.begin(), octaves.end(), true) - octaves.begin();
  const auto reach = static_cast<Eigen::Index>(
      reach_factor * sample_rate / (lowest_frequency * std::exp2(static_cast<double>(lowest))));
  begin = std::max<Eigen::Index>(0, begin - reach);
  end = std::min<Eigen::Index>(force.cols(), end + reach);
  const auto count = static_cast<std::size_t>(end - begin);
  signal::RealFft fft(signal::good_fft_size(count + static_cast<std::size_t>(reach)));
  const double turn = 2 * std::numbers::pi * sample_rate / static_cast<double>(fft.size());
  std::vector<std::vector<std::complex<double>>> spectra(3);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    if (force.row(axis).isZero(0)) continue;
    std::fill(fft.signal().begin(), fft.signal().end(), 0.0);
    for (std::size_t n = 0; n < count; ++n) {
      fft.signal()[n] = force(axis, begin + static_cast<Eigen::Index>(n));
    }
    fft.forward();
    spectra[static_cast<std::size_t>(axis)].assign(fft.spectrum().begin(), fft.spectrum().end());
  }
  std::vector<double> gains(fft.bins(), 0.0);
  for (std::size_t octave = 0; octave < mode_octaves; ++octave) {
    if (!octaves[octave]) continue;
    rates[octave].setZero(3, force.cols());
    // The middle of the octave.
    const double omega =
        2 * std::numbers::pi * lowest_frequency * std::exp2(static_cast<double>(octave) + 0.5);
    for (std::size_t bin = 1; bin < gains.size(); ++bin) {
      const double at = turn * static_cast<double>(bin);
      gains[bin] = at * modal::slow_fraction(omega, 2 * std::numbers::pi / at);
    }
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const auto& spectrum = spectra[static_cast<std::size_t>(axis)];
      if (spectrum.empty()) continue;
      for (std::size_t bin = 0; bin < spectrum.size(); ++bin) {
        fft.spectrum()[bin] = {-gains[bin] * spectrum[bin].imag(),
                               gains[bin] * spectrum[bin].real()};
      }
      fft.inverse();
      for (std::size_t n = 0; n < count; ++n) {
        rates[octave](axis, begin + static_cast<Eigen::Index>(n)) =
            static_cast<float>(fft.signal()[n]);
      }
    }
  }
  return rates;
}

}  // namespace carillon::synth::motion
