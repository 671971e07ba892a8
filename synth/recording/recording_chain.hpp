#pragma once

#include <cstddef>
#include <span>

#include "core/random.hpp"

namespace carillon::synth::recording {

/// The clip `delay` samples later: what comes before is silence, what would come after the end is
/// lost, nothing wraps around. Whole numbers of samples only move; fractions go through a sinc of
/// 128 samples under Kaiser's window (beta 10), whose error is below -90 dB up to 0.45 of the
/// sample rate.
/// @throws InputError  the delay is negative or not finite
void shift_later(std::span<float> clip, double delay);

/// Multiplies by `decibels`.
/// @throws InputError  the result is beyond single precision
void apply_gain(std::span<float> clip, double decibels);

/// Limits samples to [-level, level].
/// @return how many were beyond
/// @throws InputError  the level is not positive
std::size_t clip_at(std::span<float> clip, double level);

/// Rounds to the steps of a converter of `bits` bits, full scale 1.0: multiples of 2^(1-bits) from
/// -1 to 1 - 2^(1-bits). Equal distances go to the even step.
///
/// @param dither  adds noise of triangular distribution over two steps before rounding (TPDF;
///                Lipshitz, Wannamaker and Vanderkooy 1992: mean and variance of the error do not
///                depend on the signal); null: none
/// @return how many samples were beyond full scale
/// @throws InputError  bits not from 2 to 24, or a sample is not finite
std::size_t quantise(std::span<float> clip, int bits, core::RandomStream* dither);

/// Silence from a sample on, after a fade of the shape of a raised cosine that ends there.
/// @param end, fade  [samples]; an end beyond the clip changes nothing but what the fade takes
void stop_at(std::span<float> clip, double end, double fade);

/// Whether nothing is left of a clip when it is rounded to `bits` bits without dither.
bool silent_after_rounding(std::span<const float> clip, int bits);

}  // namespace carillon::synth::recording
