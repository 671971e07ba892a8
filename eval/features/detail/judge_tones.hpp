#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "eval/features/detail/tone_fit.hpp"

namespace carillon::eval::features {

/// How well a tone of a fit decays as one damped sinusoid does.
struct ToneJudgement {
  /// By how much its amplitude would differ if it were fitted to its later part alone, as a
  /// fraction of it, beyond what noise makes: after 1.5 / d, or in the second half of the signal.
  double drift = 0;
  /// The later part agrees within half of the amplitude or three standard errors. Bursts, tones
  /// that make up the difference between a mode and a damped sinusoid, and parts of what a codec
  /// has smeared do not.
  bool is_mode = true;
};

/// @param residual  of the signal, less all tones of the fit
ToneJudgement judge(const ToneFit& fit, std::size_t tone, std::span<const double> residual);

/// Tones beside a stronger one in the same line whose amplitude is not known from nothing: the two
/// are one, or describe one that is not quite exponential.
std::vector<std::size_t> indistinct(const ToneFit& fit);

/// Adds to the tones that are left out those of which half or more is what others of them take
/// away again.
/// @param left_out  one for each tone of the fit
std::vector<bool> depending_on(const ToneFit& fit, std::vector<bool> left_out);

enum class Steadiness { mode, hum, neither };

/// What decides whether a slow tone is a mode or a hum.
struct SlowTone {
  double frequency = 0;   ///< [Hz]
  double decay_rate = 0;  ///< [1/s], may be negative
  double decay_rate_error = 0;
  double amplitude = 0;  ///< at the onset
  double duration = 0;   ///< in which it was heard [s]
};
/// A hum is there before the strike with half of its level or more. Where nothing was recorded
/// before, it does not decay by 5 % while it is heard, or by 40 % and within three errors not at
/// all, and lies at a multiple of 50 or 60 Hz up to 1,200 Hz (within 0.3 %, as mains keep it), or
/// its level stays within 2 %. What grows otherwise is neither.
/// @param quiet  samples before the strike
Steadiness steadiness(const SlowTone& tone, std::span<const double> quiet, double sample_rate);

}  // namespace carillon::eval::features
