#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace carillon::eval::features {

/// Coefficients a[0] = 1, a[1], ... of the prediction error sum_j a[j] x[n - j] of smallest power,
/// forward and backward (Burg 1975); fewer where the error vanishes.
std::vector<double> prediction_error_filter(std::span<const double> samples, std::size_t order);

/// First samples of the strikes in a recording, in order.
///
/// What rings freely is a sum of damped sinusoids, and so predicted by the samples before it; what
/// is struck anew is not. A strike is a burst of the prediction error (order 32, from the 0.4 s
/// after the loudest millisecond): six times what the 25 ms before show at any place, since the
/// strike before it, 15 times their median, and within 30 dB of the largest before it, 40 dB after
/// it burst after the same strike; it begins where the power of the error changes. Two are told
/// apart from 5 ms on. Lost samples are bursts, too.
///
/// A recording that begins at its strike or in it shows none there.
///
/// @param samples  finite
std::vector<std::size_t> find_strikes(std::span<const double> samples, double sample_rate);

/// First sample of a change of power: the place that splits the samples into two parts of Gaussian
/// noise of different power with the largest likelihood (Maeda 1985: Akaike's criterion picks the
/// onset of earthquakes). Power below -40 dB of the peak counts as none.
/// @param samples  a part with one change in it; 0 where there are fewer than 8 samples
std::size_t change_of_power(std::span<const double> samples);

}  // namespace carillon::eval::features
