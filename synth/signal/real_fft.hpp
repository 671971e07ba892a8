#pragma once

#include <complex>
#include <cstddef>
#include <mutex>
#include <span>

namespace carillon::synth::signal {

/// FFTW makes and destroys plans in one thread at a time; running them needs no lock.
std::mutex& fft_planner();

/// The smallest length from `count` on that is a product of 2, 3, 5 and 7 and even: FFTW is at its
/// best there, and never twice as long as needed.
std::size_t good_fft_size(std::size_t count);

/// Transform of a real signal of one length and back, in double precision, with buffers of its own:
/// one object for each thread. Plans are estimated, so that no clock decides about the last bits.
class RealFft {
 public:
  /// @throws InputError  a size of 0 or one beyond 2^31
  explicit RealFft(std::size_t size);
  ~RealFft();
  RealFft(const RealFft&) = delete;
  RealFft& operator=(const RealFft&) = delete;

  std::size_t size() const { return size_; }
  std::size_t bins() const { return size_ / 2 + 1; }
  std::span<double> signal() { return {signal_, size_}; }
  std::span<std::complex<double>> spectrum() { return {spectrum_, bins()}; }

  /// signal() -> spectrum(), exp(-i omega t), no factor. The signal stays as it is.
  void forward();
  /// spectrum() -> signal(), with the factor 1 / size; the spectrum is lost.
  void inverse();

 private:
  std::size_t size_;
  double* signal_;
  std::complex<double>* spectrum_;
  void* forward_;
  void* inverse_;
};

/// Log magnitudes in spectrum() become the log spectrum of the minimum-phase response that has
/// them.
void to_minimum_phase(RealFft& fft);

}  // namespace carillon::synth::signal
