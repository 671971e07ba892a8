#pragma once

#include <complex>
#include <cstddef>
#include <span>

#include "core/fft.hpp"

namespace carillon::synth::signal {

/// The smallest length from `count` on that is a product of 2, 3, 5 and 7 and even: FFTW is at its
/// best there, and never twice as long as needed.
std::size_t good_fft_size(std::size_t count);

/// Transform of a real signal of one length and back, in double precision, with buffers of its own:
/// one object for each thread.
class RealFft {
 public:
  /// @throws InputError  a size of 0 or one beyond 2^31
  explicit RealFft(std::size_t size);

  std::size_t size() const { return size_; }
  std::size_t bins() const { return size_ / 2 + 1; }
  std::span<double> signal() { return {signal_.get(), size_}; }
  std::span<std::complex<double>> spectrum() {
    return {reinterpret_cast<std::complex<double>*>(spectrum_.get()), bins()};
  }

  /// signal() -> spectrum(), exp(-i omega t), no factor. The signal stays as it is.
  void forward();
  /// spectrum() -> signal(), with the factor 1 / size; the spectrum is lost.
  void inverse();

 private:
  std::size_t size_;
  core::FftNumbers signal_, spectrum_;
  core::FftPlan forward_, inverse_;
};

/// Log magnitudes in spectrum() become the log spectrum of the minimum-phase response that has
/// them.
void to_minimum_phase(RealFft& fft);

}  // namespace carillon::synth::signal
