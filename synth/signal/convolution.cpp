#include "synth/signal/convolution.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"

namespace carillon::synth::signal {

RealFft& Convolver::transform(std::size_t size) {
  auto& found = transforms_[size];
  if (!found) found = std::make_unique<RealFft>(size);
  return *found;
}

ResponseSpectrum Convolver::prepare(std::span<const double> response, std::size_t clip) {
  response = response.first(std::min(response.size(), clip));
  while (!response.empty() && response.back() == 0) response = response.first(response.size() - 1);
  ResponseSpectrum spectrum;
  spectrum.clip = clip;
  if (response.empty()) return spectrum;
  // The end of the full convolution, which nobody hears, must not come round to its beginning.
  spectrum.size = good_fft_size(clip + response.size() - 1);
  RealFft& fft = transform(spectrum.size);
  std::fill(std::copy(response.begin(), response.end(), fft.signal().begin()), fft.signal().end(),
            0.0);
  fft.forward();
  spectrum.values.assign(fft.spectrum().begin(), fft.spectrum().end());
  return spectrum;
}

void Convolver::add(std::span<const float> dry, const ResponseSpectrum& response,
                    std::span<float> output) {
  if (dry.size() != response.clip || output.size() != response.clip) {
    throw core::InputError(
        fmt::format("a clip of {} samples into {}, but the room's response was made ready for {}",
                    dry.size(), output.size(), response.clip));
  }
  if (response.size == 0) return;
  RealFft& fft = transform(response.size);
  std::fill(std::copy(dry.begin(), dry.end(), fft.signal().begin()), fft.signal().end(), 0.0);
  fft.forward();
  const auto spectrum = fft.spectrum();
  for (std::size_t k = 0; k < spectrum.size(); ++k) {
    // Written out: std::complex's product looks for infinities in every bin.
    const double re = spectrum[k].real() * response.values[k].real() -
                      spectrum[k].imag() * response.values[k].imag();
    const double im = spectrum[k].real() * response.values[k].imag() +
                      spectrum[k].imag() * response.values[k].real();
    spectrum[k] = {re, im};
  }
  fft.inverse();
  for (std::size_t n = 0; n < output.size(); ++n) {
    output[n] = static_cast<float>(static_cast<double>(output[n]) + fft.signal()[n]);
  }
}

}  // namespace carillon::synth::signal
