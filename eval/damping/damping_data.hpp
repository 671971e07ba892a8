#pragma once

#include <span>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval::damping {

/// Damping coefficients against eigenvalues: what damping models are fitted to.
struct DampingData {
  std::vector<double> eigenvalues;   ///< lambda [rad^2/s^2]
  std::vector<double> coefficients;  ///< c = 2 d [1/s]
  std::vector<double> errors;        ///< standard errors of c [1/s]; empty: unknown
  /// Standard errors that are in proportion to what c truly is, as those of reverberant_modes()
  /// are; 0: not in proportion; empty: none is. The mixture takes them in place of errors: where
  /// they are large, what came out too small would seem too exact.
  std::vector<double> proportions;
  /// c [1/s] above which a point would have been left out, as a room hides what decays faster than
  /// itself; infinite: none; empty: none for any
  std::vector<double> ceilings;
  std::size_t size() const { return eigenvalues.size(); }
};

/// c of a room's own decay where a mode of some frequency is heard, 2 ln(1000) / RT60 [1/s].
/// @param rt60  by octave from 125 Hz on [s], the last one holds above; not empty; 0: no room
double room_ceiling(std::span<const double> rt60, double frequency);

/// c = 2 d and lambda = omega_d^2 + d^2 of each feature; those marked as reverberant are left out.
/// @param rt60  of the room, by octave from 125 Hz on [s], the last one holds above: what decays
///              faster has been left out, and ceilings say so; what is not exact within 6 % may be
///              the room's own fluctuation, and is left out too; empty: no room
DampingData damping_data(std::span<const features::Feature> features,
                         std::span<const double> rt60 = {});

/// The same of modes whose rates were found by how the room is known to decay
/// (reverberant_modes()): what decays faster than the room is among them.
DampingData reverberant_data(std::span<const features::Feature> modes);

/// All of them together. Errors are known where they are of every one.
DampingData joined(std::span<const DampingData> parts);

}  // namespace carillon::eval::damping
