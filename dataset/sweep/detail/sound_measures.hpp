#pragma once

#include <optional>
#include <span>

namespace carillon::dataset::sweep {

/// What one clip is like. Nothing where it is silent or does not decay.
struct SoundMeasures {
  double level_db = 0;     ///< root mean square over the clip, against 1
  double peak_db = 0;      ///< largest magnitude, against 1
  double centroid_hz = 0;  ///< centre of gravity of the power spectrum
  /// Time that a fall by 60 dB takes [s], at the slope of a straight line through the levels of
  /// frames of 5 ms, from the loudest one to the first that is 30 dB below it or the clip's end.
  std::optional<double> decay_s;
};

/// @param sample_rate  [Hz]
/// @return nothing for a silent clip
std::optional<SoundMeasures> measure_sound(std::span<const float> clip, double sample_rate);

}  // namespace carillon::dataset::sweep
