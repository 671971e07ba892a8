#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace carillon::eval::features {

/// The part of a recording in which a struck object rings by itself.
struct Segment {
  std::size_t onset = 0;    ///< sample at which the strike begins
  std::size_t quiet = 0;    ///< samples before the first of all strikes
  std::size_t begin = 0;    ///< after contact and after the last clipped sample
  std::size_t end = 0;      ///< before the next strike, or the end of what is there
  std::size_t clipped = 0;  ///< samples at full scale after the onset
  std::vector<std::string> remarks;
  std::string nothing;  ///< why there is no such part; "" where there is
};

/// Finds the loudest strike and what rings after it.
///
/// Strikes are bursts of what cannot be predicted from the samples before (find_strikes()), each
/// begins where the power changes (change_of_power()). The loudest is taken; of several within
/// 0.1 s of one another the last, after which all of them ring, if it rings for longer. Without a
/// strike (the recording begins with it, or swells) the onset is where the short-time energy of the
/// sound without its slow parts first comes to 1 % of the loudest 3 ms, and above what was there
/// before. The part ends before the next strike, and where a millisecond of samples is equal.
/// Clipped: three or more equal samples at the largest value, with a step at either side that a
/// smooth top does not have.
///
/// @param samples  finite
/// @param onset    [s] given instead of found
/// @param contact  [s] left out after the onset
Segment find_segment(std::span<const double> samples, double sample_rate,
                     std::optional<double> onset, double contact);

}  // namespace carillon::eval::features
