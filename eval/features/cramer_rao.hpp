#pragma once

#include <span>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval::features {

/// The least standard deviations that any unbiased estimate from one recording can have.
struct ModeBound {
  double frequency = 0;   ///< [Hz]
  double decay_rate = 0;  ///< [1/s]
};

/// What of a recording is analysed, and its noise.
struct Observation {
  double sample_rate = 44100;  ///< [Hz]
  double begin = 0;            ///< [s] from the onset
  double end = 1;              ///< [s]
  double noise = 0;            ///< standard deviation of white noise, in the amplitudes' unit
};

/// Cramer-Rao bounds of modes that ring together: the inverse of the Fisher information of the
/// sampled sum a exp(-d t) cos(2 pi f t + phase) in white noise, all four parameters of every mode
/// unknown.
/// @param modes  frequency, decay_rate, amplitude and phase of each, n values
/// @return n values
/// @throws InputError  no noise, nothing observed, or modes that cannot be told apart
std::vector<ModeBound> cramer_rao(std::span<const Feature> modes, const Observation& observation);

}  // namespace carillon::eval::features
