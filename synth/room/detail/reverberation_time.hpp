#pragma once

#include <optional>
#include <span>
#include <vector>

namespace carillon::synth::room {

/// A reverberation time read from a decay.
struct DecayFit {
  double rt60 = 0;           ///< [s], to -60 dB along the fitted line
  double correlation = 0;    ///< of level and time on the fitted stretch; -1 for a straight decay
  double dynamic_range = 0;  ///< [dB] from the start of the decay to the noise floor
};

/// Reverberation time of an impulse response by a line through its Schroeder curve from -5 dB to
/// -5 - `decay` dB (20: T20; 30: T30), least squares over the samples. The response is cut where it
/// meets its noise floor (Lundeby's crossing, taken from the power of the last tenth) and the
/// energy that the line would have had beyond is put back, so that an exponential decay gives its
/// own time however short it was cut.
/// @param decay  [dB], above 0
/// @return  nothing unless the dynamic range is at least `decay` + 10 dB, or with fewer than three
///          samples on the stretch
/// @throws InputError  nothing but zeros, a value that is not finite, a rate or a decay that is not
///                     positive
std::optional<DecayFit> reverberation_time(std::span<const double> response, double sample_rate,
                                           double decay = 30);

/// A response within one octave, without shift in time: raised-cosine edges over an eighth of an
/// octave at either end, zero phase, nothing outside. It rings itself for about 12 periods of the
/// centre (100 ms in the octave of 125 Hz): much shorter times cannot be read through it.
/// @param centre  [Hz]; its octave begins below half the sample rate
std::vector<double> octave_band(std::span<const double> signal, double sample_rate, double centre);

}  // namespace carillon::synth::room
