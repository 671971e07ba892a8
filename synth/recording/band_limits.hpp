#pragma once

#include <span>

namespace carillon::synth::recording {

/// Butterworth filters by the bilinear transform, their edges kept (Oppenheim and Schafer,
/// Discrete-Time Signal Processing, 3rd ed., section 7.3): 3 dB less at `edge`, in place, from
/// silence.

/// A microphone's or loudspeaker's upper limit, 24 dB for each octave (order 4).
/// @throws InputError  an edge that is not above 0 and below half the rate [Hz]
void cut_above(std::span<float> clip, double edge, double sample_rate);

/// Its lower limit, or a switch against rumble, 12 dB for each octave (order 2).
/// @throws InputError  as cut_above
void cut_below(std::span<float> clip, double edge, double sample_rate);

}  // namespace carillon::synth::recording
