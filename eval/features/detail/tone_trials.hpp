#pragma once

#include <complex>
#include <span>

#include "eval/features/detail/tone_fit.hpp"

namespace carillon::eval::features {

/// By how much chi squared falls for a tone that noise alone does not make: in one clip of a
/// hundred it does, at some 1e5 places times a dozen decay rates.
inline constexpr double new_tone = 40;

/// Whether a rate is within the line of a tone: what is left there is that tone's own misfit, or it
/// is two.
bool beside_tone(const ToneFit& fit, std::complex<double> rate);

/// Adds a tone of about this rate, refined with its neighbours, if chi squared falls by more than
/// `threshold`, every tone near it stays one that can be told from the others, and none has less
/// than a hundredth of another's energy in the same line, or a thousandth beside it.
bool try_tone(ToneFit& fit, std::complex<double> rate, double threshold);

/// Refines a tone with its neighbours where it leaves more than noise around it, and says whether
/// it still does: more than beside it, and that is new since the last try to put two in its place.
bool misfits(ToneFit& fit, std::size_t tone);

/// Puts two tones in place of one that leaves more than noise around it, where they explain more
/// and can be told apart. Two that explain most of what is left, and four times what is asked of
/// others, need not be told apart before the noise is known anew. Several pairs are tried, among
/// them what ESPRIT finds in the band.
/// @param signal  the residual over time
bool try_pair(ToneFit& fit, std::size_t tone, std::span<const double> signal);

/// Rates of the tones in a band of the residual around one, wide enough for its decay.
std::vector<std::complex<double>> rates_around(const ToneFit& fit, std::span<const double> signal,
                                               std::complex<double> rate);

/// Takes out tones that the noise could have made or that are one with a neighbour.
/// @return  whether there were any
bool prune(ToneFit& fit);

}  // namespace carillon::eval::features
