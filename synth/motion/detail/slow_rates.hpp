#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace carillon::synth::motion {

/// Octaves of modes, from 20 Hz on.
inline constexpr std::size_t mode_octaves = 11;
/// Which one a mode belongs to: the first below 40 Hz, the last from 20480 Hz on.
std::size_t octave_of(double eigenvalue);

/// Rates of change of a force as far as it is slow against the modes of each octave, as a readout's
/// force_rate asks for them: each frequency by 1 / (1 + (f / f_octave)^8) (slow_fraction()),
/// without delay.
/// @param force     of equal steps, 0 before and after [N]
/// @param octaves   which are asked for
/// @return for each octave as many columns as the force has [N/s], none where it is not asked for
std::vector<Eigen::Matrix3Xf> slow_rates(const Eigen::Matrix3Xd& force, double sample_rate,
                                         const std::vector<bool>& octaves);

}  // namespace carillon::synth::motion
