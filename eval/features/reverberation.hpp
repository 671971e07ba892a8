#pragma once

#include <span>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval {

/// Decay rate of a room's sound [1/s]: ln(1000) / RT60 in the octave of a frequency.
/// @param rt60  reverberation times by octave from 125 Hz on [s], the last one holds above; not
///              empty; 0: does not reverberate
double room_decay_rate(std::span<const double> rt60, double frequency);

/// Marks features that decay faster than the room as reverberant.
void mark_faster(std::span<const double> rt60, std::vector<Feature>& features);

/// Tells modes from the room's own decays. A room's sound is dense in frequency: what is fitted to
/// its fluctuations decays up to several times slower than the room for as long as it is heard. A
/// mode stays when the room is gone: it has to be 25 dB above what the room makes of all that rings
/// within the same width of the room's resonances, before it sinks into the noise.
/// @param early  of the whole sound; those that `late` does not bear out are marked as reverberant
/// @param late   of the sound from `begin` on, when the room has decayed for some time; they take
///               the place of early ones in their line
/// @param begin  [s] after the onset
std::vector<Feature> without_room(std::vector<Feature> early, std::span<const Feature> late,
                                  double begin, std::span<const double> rt60);

}  // namespace carillon::eval
