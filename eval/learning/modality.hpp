#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace carillon::eval::learning {

/// What a network perceives of a sample.
enum class Modality {
  spectrogram,  ///< mel power spectrogram, relative to the clip's loudest cell, 0 to 1
  waveform,     ///< samples at 22,050 Hz, the largest of them 1
  voxels,       ///< -1 outside, 1 inside
  image,        ///< 64 x 64 pixels, red, green and blue from 0 to 1; one or several views
  touch         ///< force on a stylus, x, y and z, of unit root mean square
};

inline constexpr Modality all_modalities[] = {Modality::spectrogram, Modality::waveform,
                                              Modality::voxels, Modality::image, Modality::touch};

/// As configurations and tables name it.
std::string_view name_of(Modality modality);

/// How spectrograms are given.
enum class SpectrogramScale {
  decibels,  ///< below the loudest cell: 1 - decibels / range, 0 below the range
  power      ///< as they are, of each clip between 0 and 1 (Sterling 2019, section 6.3.1)
};
inline constexpr SpectrogramScale all_spectrogram_scales[] = {SpectrogramScale::decibels,
                                                              SpectrogramScale::power};
std::string_view name_of(SpectrogramScale scale);

/// Of a method that gets spectrograms.
struct SpectrogramInput {
  SpectrogramScale scale = SpectrogramScale::decibels;
  double range = 60;  ///< of decibels [dB]
  /// @param relative  powers relative to the loudest, overwritten
  void apply(std::span<float> relative) const;
};

/// Extent of what a network gets of one sample: channels, then the modality's own axes.
/// spectrogram {1, bands, frames}, waveform {1, samples}, voxels {turned copies, r, r, r}, image
/// {3, 64, 64} or of several views {views, 3, 64, 64}, touch {3, ticks}.
using ModalityExtent = std::vector<std::int64_t>;
std::size_t values_in(const ModalityExtent& extent);

/// What becomes of raw values before a network gets them. Each takes one sample.
/// All throw InputError where a value is not finite; the caller knows which sample it is.
namespace prepare {

/// @param power  mel powers of a clip, overwritten by those relative to the loudest; a silent clip
///               becomes all 0
/// @return whether anything sounds
bool spectrogram(std::span<float> power);

/// Sample rate of waveforms [Hz], as SoundNet's (Aytar et al. 2016).
inline constexpr double waveform_rate = 22050;
/// @param clip  at `sample_rate`
/// @return silent clips stay all 0
std::vector<float> waveform(std::span<const float> clip, double sample_rate);

/// Sides of images [pixels].
inline constexpr std::size_t image_side = 64;
/// Means over the pixels that each new one covers.
/// @param pixels  height x width x 3, sRGB
/// @param planes  3 x image_side x image_side
void image(std::span<const std::uint8_t> pixels, std::size_t height, std::size_t width,
           std::span<float> planes);

/// @param force  ticks x 3 [N]
/// @param planes  3 x ticks
void touch(std::span<const float> force, std::span<float> planes);

}  // namespace prepare
}  // namespace carillon::eval::learning
