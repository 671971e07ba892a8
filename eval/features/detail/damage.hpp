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
