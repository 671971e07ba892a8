#pragma once

#include <vector>

#include "synth/room/room_acoustics.hpp"

namespace carillon::synth::room {

/// Least loss of a direct sound that is computed [dB].
inline constexpr double min_air_loss = 0.01;

/// Loss of pressure over a distance at a frequency by ISO 9613-1, at most 120 dB [dB].
double air_loss(double frequency, double distance, const Air& air);

/// What air does to a sound on its way: the minimum-phase response whose magnitude is
/// exp(-m(f) distance / 2) at every frequency (Oppenheim and Schafer, Discrete-Time Signal
/// Processing, 3rd ed., section 13.5), 46 ms long, without the time of flight. Losses are causal:
/// their phase belongs to their magnitude as that of any minimum-phase system does.
/// @param distance  [m]
/// @return  empty where it takes less than min_air_loss at every frequency up to half the rate
/// @throws InputError  air outside its limits, a sample rate that is not positive, a negative
///                     distance
std::vector<double> air_response(double distance, const Air& air, double sample_rate);

}  // namespace carillon::synth::room
