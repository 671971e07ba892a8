#pragma once

#include <complex>
#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "synth/signal/real_fft.hpp"

namespace carillon::synth::signal {

/// A response made ready for convolving clips of one length: its spectrum.
struct ResponseSpectrum {
  std::size_t clip = 0;  ///< samples of the clips
  std::size_t size = 0;  ///< of the transform; 0: a silent response
  std::vector<std::complex<double>> values;
};

/// Convolves clips with responses in one block each. Plans are made once for a length. Uses buffers
/// of its own: one object for each thread.
class Convolver {
 public:
  /// Spectrum of a response, of which only the first `clip` samples can be heard.
  ResponseSpectrum prepare(std::span<const double> response, std::size_t clip);

  /// Adds the first samples of `dry * response` to `output`, as many as the clip has. Output may be
  /// the dry clip itself.
  /// @throws InputError  a clip or an output of another length than the response was prepared for
  void add(std::span<const float> dry, const ResponseSpectrum& response, std::span<float> output);

 private:
  RealFft& transform(std::size_t size);
  std::map<std::size_t, std::unique_ptr<RealFft>> transforms_;
};

}  // namespace carillon::synth::signal
