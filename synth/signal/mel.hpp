#pragma once

#include <array>
#include <span>
#include <vector>

#include "synth/signal/real_fft.hpp"

namespace carillon::synth::signal {

/// librosa's mel power spectrogram: Slaney scale and area norm, power 2, periodic Hann, centred
/// frames with zero padding; linear, not normalised.
struct MelOptions {
  double sample_rate = 44100;  ///< [Hz]
  int fft_size = 2048;
  int hop = 1837;  ///< 25 frames of 1 s at 44.1 kHz
  int bands = 64;
  double min_frequency = 0;  ///< [Hz]
  double max_frequency = 0;  ///< [Hz]; 0: half the sample rate
};

/// Frames of a clip: 1 + count / hop.
/// @throws InputError  impossible options, as MelSpectrogram
int mel_frames(std::size_t count, const MelOptions& options);

/// Computes many spectrograms of one definition (the FFT's plan and filters are made once). Uses
/// buffers of its own: one object for each thread.
class MelSpectrogram {
 public:
  /// @throws InputError  no positive sample rate, hop or bands, an odd FFT size, or band limits
  ///                     that do not rise within 0 to Nyquist
  explicit MelSpectrogram(const MelOptions& options);
  /// @return bands x frames, row by row
  std::vector<float> operator()(std::span<const float> clip) const;
  /// Filter weights, bands x (fft_size / 2 + 1).
  const std::vector<float>& filters() const { return filters_; }
  const MelOptions& options() const { return options_; }

 private:
  MelOptions options_;
  std::vector<float> filters_;
  std::vector<std::array<std::size_t, 2>> within_;  ///< of each band, first bin of weight and end
  std::vector<double> window_;
  mutable RealFft fft_;
};

}  // namespace carillon::synth::signal
