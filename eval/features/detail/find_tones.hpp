#pragma once

#include <cstddef>
#include <span>

#include "eval/features/detail/tone_fit.hpp"

namespace carillon::eval::features {

struct ToneSearch {
  double sample_rate = 0;     ///< [Hz]
  double min_frequency = 20;  ///< [Hz]
  double max_frequency = 20000;
  std::size_t max_tones = 500;  ///< tones
  double min_energy = 1e-6;     ///< of the strongest tone's; weaker ones are not looked for
};

/// The damped sinusoids of a signal that begins when they do and is free of what drives them.
///
/// Rounds of: where the residual holds one (generalised likelihood ratio over frequencies and a
/// grid of decay rates); what the band around it holds (ESPRIT); what of it the likelihood bears
/// out (chi squared falls by more than 40, by 24 for the second of a pair); refinement of all of
/// them together with their neighbours; a new estimate of the noise. Ends when nothing is left.
///
/// @param samples  at least 64, an even product of 2, 3, 5 and 7
/// Tones found may decay slowly, not at all, or grow a little: hums are told apart by the caller.
ToneFit find_tones(std::span<const double> samples, const ToneSearch& search);

/// The largest even product of 2, 3, 5 and 7 that is at most `count`; 0 below 2.
std::size_t largest_fft_size(std::size_t count);

}  // namespace carillon::eval::features
