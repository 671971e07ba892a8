#pragma once

namespace carillon::synth {

/// Force of a blow of unit impulse over time.
struct ContactForce {
  double duration = 0;  ///< [s] of the raised cosine; 0: an ideal impulse
};

}  // namespace carillon::synth
