#pragma once

#include <vector>

namespace carillon::synth {

/// Force of a blow of unit impulse over time.
struct ContactForce {
  double duration = 0;  ///< [s] of the raised cosine; 0: an ideal impulse
  /// Where not empty, the force itself [1/s] at equal steps from 0 to the duration, both ends
  /// included, straight between them; then the raised cosine is not used.
  std::vector<double> samples;
};

}  // namespace carillon::synth
