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

/// First of a millisecond of equal samples that are not clipped, while the sound is there: above
/// -60 dB of its peak and 16 steps of a converter in the 5 ms before. Silence before the first
/// sample that moves is none.
std::optional<std::size_t> find_gap(std::span<const double> samples, std::size_t from,
                                    double sample_rate);

}  // namespace carillon::eval::features
