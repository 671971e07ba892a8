#pragma once

#include <span>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval::features {

/// Marks features that decay faster than the room as reverberant.
void mark_faster(std::span<const double> rt60, std::vector<Feature>& features);

/// The part of a sound after the room has decayed for some time.
struct Late {
  double begin = 0;   ///< [s] after the onset
  double length = 0;  ///< [s]
};

/// Features of the late part that are no decay of the room's own. A room's sound is dense in
/// frequency: what is fitted to its fluctuations decays up to several times slower than the room
/// for as long as it is heard. A mode stays when the room is gone: it has to be 25 dB above what
/// the room makes of all that rings within the width of the room's resonances, before it comes
/// within 10 dB of the noise or the end.
std::vector<Feature> outlasting(std::span<const Feature> features, const Late& late,
                                std::span<const double> rt60);

/// How long the late part of a sound must be for that [s], where a mode does not decay itself.
double time_to_stand_out(double room_rate);

/// Features of all of a sound, with those that outlast the room in the place of what was found in
/// their line; all others are marked as reverberant, where there is a room.
std::vector<Feature> replaced_by(std::span<const Feature> modes, std::vector<Feature> early,
                                 std::span<const double> rt60);

}  // namespace carillon::eval::features
