#pragma once

#include <span>
#include <vector>

#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::material {

struct RoomFit {
  synth::damping::DampingModel model;     ///< with the numbers found
  std::vector<core::Range> confidence95;  ///< one for each number; infinite ends: not bounded
  double sigma = 0;  ///< relative scatter of modes that the room does not touch
  /// How many points show their own decay and not the room's: the sum of their probabilities,
  /// those known to 15 % in full, others by (15 % / scatter)^2.
  double own = 0;
};

/// A damping law fitted to decay rates that were heard in a room.
///
/// What decays faster than the room is heard as the room's decay, or at its own rate where direct
/// sound is strong; nobody says which. A mode whose law is c in a room of C, with u = c / C, has
/// the density, in the logarithm of the c_i that is heard,
///     w t4(ln(c_i / c); s_i) + (1 - w) N(ln(c_i / C) - min(0.6 ln max(u, 1), 0.5); 0.6)
///       + 0.02 logistic(ln(c_i / c)),
///     w = 0.05 + 0.9 / (1 + (u / 0.7)^4),   s_i^2 = s^2 + error_i^2 + (u^2 / 4)^2, u below 3
///     there,
/// with Student's t of 4 degrees of freedom, the features' own errors relative to c_i (15 % where
/// one is not known) and ln s normal about ln 0.03 (deviation 0.7). The intervals are those of the
/// profile likelihood, with the limit of Student's t for as many points as show their own decay.
/// @param rooms  C of the room at each point [1/s]; infinite: heard without a room
/// @throws InputError  as fit_damping()
RoomFit fit_in_room(const damping::DampingData& data, std::span<const double> rooms,
                    const damping::DampingLaw& law);

}  // namespace carillon::eval::material
