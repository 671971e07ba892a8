#pragma once

#include <span>

namespace carillon::eval::recorded_objects {

/// When a hammer touched, and for how long.
struct ImpactContact {
  double begin = 0;     ///< [s] from the recording's first sample
  double duration = 0;  ///< of the raised cosine that spreads over time as the force does [s]
};

/// The contact that a recorded force shows: what is above a fiftieth of its maximum around it, as
/// RealImpact's own scripts cut it out. It is taken for the raised cosine of the same middle and
/// variance in time, which has the force's spectrum to second order in frequency.
/// @param force  of any unit; negative values count as none
/// @throws InputError  no force at all
ImpactContact contact_of(std::span<const double> force, double sample_rate);

}  // namespace carillon::eval::recorded_objects
