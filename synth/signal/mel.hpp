#pragma once

#include <array>
#include <span>
#include <string>
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
  /// Made smaller to so many bands and frames, each the mean of what it covers, as an image is
  /// (Sterling 2019, section 6.3.1: an overlap of 25 %, then 64 x 25); 0: as computed.
  int resized_bands = 0, resized_frames = 0;
};

/// Cells of a spectrogram.
struct MelExtent {
  int bands = 0, frames = 0;
};
/// Of a clip of `count` samples. Before it is resized there are 1 + count / hop frames.
/// @throws InputError  impossible options, as MelSpectrogram; fewer frames than resized ones
MelExtent mel_extent(std::size_t count, const MelOptions& options);

/// Where bands lie [Hz], as many as mel_extent has: the peaks of the triangles; of resized bands
/// the means of the peaks that they cover.
/// @throws InputError  impossible options, as MelSpectrogram
std::vector<double> mel_band_centers(const MelOptions& options);

/// When frames are [s], as many as mel_extent has: their middles, from that of the clip's first
/// sample on; of resized frames the means of the frames that they cover.
/// @throws InputError  as mel_extent
std::vector<double> mel_frame_centers(std::size_t count, const MelOptions& options);

/// Bands whose triangle holds no bin of the FFT: they would be silent whatever sounds.
/// @throws InputError  impossible options, as MelSpectrogram, but for such bands
int empty_mel_bands(const MelOptions& options);
/// What to ask for where bands are empty: the most bands that this FFT resolves, or the smallest
/// power of two that resolves these. For messages.
/// @throws InputError  as empty_mel_bands
std::string resolved_mel_bands(const MelOptions& options);

/// Computes many spectrograms of one definition (the FFT's plan and filters are made once). Uses
/// buffers of its own: one object for each thread.
class MelSpectrogram {
 public:
  /// @throws InputError  no positive sample rate, hop or bands, an odd FFT size, bands that hold no
  ///                     bin, fewer bands than resized ones, or band limits that do not rise
  ///                     within 0 to Nyquist
  explicit MelSpectrogram(const MelOptions& options);
  /// @return as mel_extent, bands x frames, row by row
  /// @throws InputError  a clip of fewer frames than resized ones
  std::vector<float> operator()(std::span<const float> clip) const;
  /// Filter weights, bands x (fft_size / 2 + 1).
  const std::vector<float>& filters() const { return filters_; }
  const MelOptions& options() const { return options_; }

 private:
  std::vector<float> computed(std::span<const float> clip, std::size_t frames) const;

  MelOptions options_;
  std::vector<float> filters_;
  std::vector<std::array<std::size_t, 2>> within_;  ///< of each band, first bin of weight and end
  std::vector<double> window_;
  mutable RealFft fft_;
};

}  // namespace carillon::synth::signal
