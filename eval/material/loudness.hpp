#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval::material {

/// How a power spectrogram is taken: Hann windows of about 23 ms, bins gathered in bands of one
/// Bark.
struct SpectrogramGrid {
  double sample_rate = 0;  ///< [Hz]
  double begin = 0;        ///< of the first frame after the onset [s]
  std::size_t window = 0;  ///< samples, a size that transforms fast
  std::size_t hop = 0;     ///< samples from frame to frame; half a window, more in long clips
  std::size_t frames = 0;
  std::size_t bands = 0;
  std::vector<std::size_t> band_of_bin;  ///< window / 2 + 1 values
};

/// @param count  samples of the clip from `begin` on
/// @throws InputError  no samples, or a rate that is not positive
SpectrogramGrid make_grid(std::size_t count, double sample_rate, double begin);

/// Powers of frames x bands, band by band within a frame: a lasting tone of amplitude a has a^2 / 2
/// in all bands together.
using BandPowers = std::vector<double>;

/// Of a clip that begins with the grid's first frame; what lies beyond its end counts as zero.
BandPowers band_powers(std::span<const double> samples, const SpectrogramGrid& grid);

/// The same of damped tones in closed form, without their samples. Powers of tones add: beats
/// between tones of one band average out. Phases are not used.
BandPowers band_powers(std::span<const features::Feature> tones, const SpectrogramGrid& grid);

/// From powers to what is heard of them.
struct LoudnessScale {
  double unit_level = 100;         ///< sound pressure level of a power of 1 [dB re 20 uPa]
  std::vector<double> background;  ///< power in each band that is always there; empty: none
};

/// Specific loudness [sone/Bark] of every frame and band, frames x bands values.
///
/// N' = 0.08 (E_TQ / E_0)^0.23 ((0.5 + 0.5 E / E_TQ)^0.23 - 1), zero below the threshold in quiet
/// E_TQ (Zwicker and Fastl 2007, eq. 8.7), E the band's power with the background's.
std::vector<double> specific_loudness(const BandPowers& powers, const SpectrogramGrid& grid,
                                      const LoudnessScale& scale);

}  // namespace carillon::eval::material
