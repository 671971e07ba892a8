#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace carillon::eval::networks {

/// Rows of channels, of which each `window` rows that follow one another give one maximum. Channels
/// are a multiple of 16. Every value comes from the same operations on every processor.
struct MaximumExtent {
  std::size_t rows = 0, channels = 0;
  std::size_t window = 1;  ///< divides the rows

  std::size_t maxima() const { return rows / window * channels; }
};

/// Mean and variance of each channel over all rows.
/// @param values  rows x channels
/// @param mean, variance  channels values; the variance is not corrected for the mean's freedom
void channel_moments(const float* values, const MaximumExtent& extent, std::span<float> mean,
                     std::span<float> variance);

/// max(0, scale value + shift), and of that each window's maximum: normalisation over a batch,
/// rectifier and maximum of a convolution's layer in one pass.
/// @param maxima  maxima() values
/// @param peaks   the value that each maximum is of
/// @param places  its row within the window, the first of equals
void normalised_maximum(const float* values, const MaximumExtent& extent,
                        std::span<const float> scale, std::span<const float> shift, float* maxima,
                        float* peaks, std::int32_t* places);

/// Sums over all maxima above 0 of each channel: of their gradients, and of these times the peak.
/// @param gradient, maxima, peaks  maxima() values
void maximum_sums(const float* gradient, const float* maxima, const float* peaks,
                  const MaximumExtent& extent, std::span<double> plain, std::span<double> by_peak);

/// Gradient by the values: constant + linear value, and at each maximum above 0 its own gradient
/// times the scale.
/// @param found  rows x channels
void maximum_gradient(const float* values, const float* gradient, const float* maxima,
                      const std::int32_t* places, const MaximumExtent& extent,
                      std::span<const float> scale, std::span<const float> constant,
                      std::span<const float> linear, float* found);

}  // namespace carillon::eval::networks
