#pragma once

#include <vector>

namespace carillon::synth::modal {

/// Force of a strike of unit impulse over time.
struct ContactForce {
  double duration = 0;  ///< [s]; 0: an ideal impulse
  /// Force of unit impulse [1/s] at equal steps over the duration, the first at 0 and the last at
  /// its end, straight lines between. Empty: the raised cosine.
  std::vector<double> samples = {};
};

/// @throws InputError  a duration that is negative or not finite, samples without a duration, a
///                     single one, or one that is not finite
void check(const ContactForce& force);

/// Integral of the force: 1 where the force keeps its word.
double impulse_of(const ContactForce& force);

/// Largest magnitude of the force [1/s]; infinite for an ideal impulse.
double peak_of(const ContactForce& force);

}  // namespace carillon::synth::modal
