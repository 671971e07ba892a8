#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace carillon::synth::signal {

/// Joins `next` to the end of `samples` such that the last `overlap` samples of the one and the
/// first of the other are mixed by cosine and sine of a quarter turn: the power of independent
/// noises stays the same throughout, and no sample jumps.
/// @throws InputError  the overlap is longer than one of them
void append_cross_faded(std::vector<double>& samples, std::span<const float> next,
                        std::size_t overlap);

}  // namespace carillon::synth::signal
