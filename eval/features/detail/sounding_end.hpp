#pragma once

#include <cstddef>
#include <span>

namespace carillon::eval::features {

/// Samples of a decaying sound after which nothing of it is left to be heard.
///
/// Four times the time in which the energy of 10 ms (of differences of neighbouring samples, which
/// leave rumble out) falls to that of the last quarter, at least 1 s; all samples where lines stand
/// out of the noise after it (20 times its median over a sixth of an octave) that were not there
/// before the strike.
///
/// @param samples  of the sound
/// @param quiet    before the strike
std::size_t sounding_end(std::span<const double> samples, std::span<const double> quiet,
                         double sample_rate);

}  // namespace carillon::eval::features
