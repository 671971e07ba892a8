#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace carillon::eval::features {

/// Equal samples at the largest or smallest value that break off with a step.
struct Clipping {
  std::size_t count = 0;
  std::size_t last = 0;  ///< one after the last of them
};
/// Three or more equal samples at the largest or smallest value of samples [from, to), with a step
/// at either side that a smooth top does not have.
Clipping find_clipping(std::span<const double> samples, std::size_t from, std::size_t to);

/// Tops of a sound that is free come ever closer to one another below the largest: a decaying
/// sinusoid has twice as many between 79 and 93 % of it as above, a sum of several still more.
/// Where a fifth more are above, a dozen at the least, and a quarter of them beside one below 75 %
/// (a slow beat has neighbours of its own size), they were limited, by a limiter or by clipping
/// that a change of the sample rate has blurred.
/// @return  one after the last top above 93 %; none: not limited
std::optional<std::size_t> limited_until(std::span<const double> samples, std::size_t from,
                                         std::size_t to);

/// Where a sound has no samples any more.
struct Gap {
  std::size_t first = 0;
  /// The sound was still there, above -60 dB of its peak and 16 steps of a converter in the 5 ms
  /// before: samples are missing. Otherwise it has decayed into silence, where the last steps of a
  /// converter without dither make lines of their own.
  bool breaks_off = false;
};
/// The first millisecond of equal samples that are not clipped, after the first that moves.
std::optional<Gap> find_gap(std::span<const double> samples, std::size_t from, double sample_rate);

}  // namespace carillon::eval::features
