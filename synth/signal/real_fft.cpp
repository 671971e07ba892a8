#include "synth/signal/real_fft.hpp"

#include <fmt/format.h>

#include "core/error.hpp"

namespace carillon::synth::signal {

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
  signal_ = core::fft_numbers(size_);
  spectrum_ = core::fft_numbers(2 * bins());
  const int extent[] = {static_cast<int>(size_)};
  forward_ = core::FftPlan::forward(extent, signal_.get(), spectrum().data());
  inverse_ = core::FftPlan::inverse(extent, spectrum().data(), signal_.get());
}

void RealFft::forward() {
  forward_.run();
}

void RealFft::inverse() {
  inverse_.run();
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
