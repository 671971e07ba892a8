#pragma once

#include <vector>

namespace carillon::synth {

/// Force of a blow of unit impulse over time.
struct ContactForce {
  double duration = 0;  ///< [s]; 0: an ideal impulse
  /// Force of unit impulse [1/s] at equal steps over the duration, the first at 0 and the last at
  /// its end, straight lines between. Empty: the raised cosine.
  std::vector<double> samples = {};
};

}  // namespace carillon::synth
