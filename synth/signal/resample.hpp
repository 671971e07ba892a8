#pragma once

#include <span>
#include <vector>

namespace carillon::synth::signal {

/// Samples at another rate (libsoxr at its highest quality, linear phase, double precision).
/// Frequencies and levels are kept up to 0.91 of half the lower rate; what lies above that half is
/// removed. Nothing is delayed, and what lies beyond the ends counts as silence.
///
/// @param from, to  sample rates [Hz], at most a factor of 1000 apart
/// @return round(size * to / from) samples; the same samples when the rates are equal
/// @throws InputError  a rate is not positive, the rates are too far apart, or a sample is not
///                     finite
std::vector<double> resample(std::span<const double> samples, double from, double to);

}  // namespace carillon::synth::signal
