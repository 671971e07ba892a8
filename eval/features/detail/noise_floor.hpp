#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "eval/features/detail/tone.hpp"

namespace carillon::eval::features {

/// Mean power |noise|^2 of every bin of a spectrum that holds narrow lines on a floor: medians over
/// a sixth of an octave, at least 48 bins, joined by straight lines in the logarithm. Lines that
/// fill less than half of that do not count.
/// @param band  bins that are looked at; others get the value at its ends
std::vector<double> noise_floor(std::span<const std::complex<double>> spectrum, BinRange band);
/// The same of powers.
std::vector<double> noise_floor(std::span<const double> powers, BinRange band);

/// The same of what is left of a signal in its last quarter, in the unit of the transform of all of
/// it.
std::vector<double> tail_floor(std::span<const double> samples, BinRange band);

}  // namespace carillon::eval::features
