#include "synth/signal/real_fft.hpp"

#include <fftw3.h>
#include <fmt/format.h>

#include "core/error.hpp"
#include "core/fft_planner.hpp"

namespace carillon::synth::signal {

std::mutex& fft_planner() {
  return core::fft_planner();
}

std::size_t good_fft_size(std::size_t count) {
  for (std::size_t size = count < 2 ? 2 : count + count % 2;; size += 2) {
    std::size_t rest = size;
    for (const std::size_t factor : {2U, 3U, 5U, 7U}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return size;
  }
}

RealFft::RealFft(std::size_t size) : size_(size) {
  if (size == 0 || size > (std::size_t{1} << 31) - 1) {
    throw core::InputError(fmt::format("a Fourier transform of {} samples", size),
                           "shorten the signal");
  }
  const std::lock_guard lock(fft_planner());
  signal_ = fftw_alloc_real(size_);
  // FFTW's complex numbers and the standard's have one layout.
  spectrum_ = reinterpret_cast<std::complex<double>*>(fftw_alloc_complex(bins()));
  auto* spectrum = reinterpret_cast<fftw_complex*>(spectrum_);
  const int n = static_cast<int>(size_);
  forward_ = fftw_plan_dft_r2c_1d(n, signal_, spectrum, FFTW_ESTIMATE | FFTW_PRESERVE_INPUT);
  inverse_ = fftw_plan_dft_c2r_1d(n, spectrum, signal_, FFTW_ESTIMATE);
}

RealFft::~RealFft() {
  const std::lock_guard lock(fft_planner());
  fftw_destroy_plan(static_cast<fftw_plan>(forward_));
  fftw_destroy_plan(static_cast<fftw_plan>(inverse_));
  fftw_free(signal_);
  fftw_free(spectrum_);
}

void RealFft::forward() {
  fftw_execute(static_cast<fftw_plan>(forward_));
}

void RealFft::inverse() {
  fftw_execute(static_cast<fftw_plan>(inverse_));
  const double factor = 1 / static_cast<double>(size_);
  for (double& value : signal()) value *= factor;
}

void to_minimum_phase(RealFft& fft) {
  // The cepstrum of a minimum-phase response is causal: fold the even one to the right
  // (Oppenheim and Schafer, Discrete-Time Signal Processing, 3rd ed., section 13.5).
  fft.inverse();
  const std::size_t size = fft.size();
  for (std::size_t n = 1; n < size; ++n) {
    fft.signal()[n] *= 2 * n < size ? 2 : 2 * n == size ? 1 : 0;
  }
  fft.forward();
}

}  // namespace carillon::synth::signal
