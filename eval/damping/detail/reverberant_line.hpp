#pragma once

#include <complex>
#include <optional>
#include <span>
#include <vector>

namespace carillon::eval::damping {

/// What a mode must have decayed by the end of a band, that its decay may be told.
inline constexpr double told_decay = 0.1;

/// A band of a sound about a frequency, shifted to 0 Hz, at a low rate; white noise stays white.
struct BandSignal {
  double frequency = 0;  ///< that is at 0 Hz now [Hz]
  double rate = 0;       ///< [1/s]
  double begin = 0;      ///< of the first sample, from the begin of what it is made of [s]
  std::vector<std::complex<double>> samples;
};

/// By a root-raised-cosine filter that reaches four of the band's samples either way; where it
/// would reach beyond the sound there are no samples.
BandSignal band_signal(std::span<const double> sound, double sample_rate, double frequency,
                       double rate);

/// A mode in a room. Its tail is Gaussian noise of a decay rate of its own (delta), so that the
/// mode is driven by noise when it is heard,
///
///   dy = (-d + i omega) y dt + sqrt(q) exp(-delta t) dW,   z = y + noise of variance R,
///
/// and its likelihood is that of a Kalman filter's innovations. Early reflections count as part of
/// the tail.
struct ReverberantLine {
  double frequency = 0;        ///< [Hz]
  double decay_rate = 0;       ///< d [1/s]
  double frequency_error = 0;  ///< standard errors, by the observed Fisher information
  double decay_rate_error = 0;
  double level = 0;      ///< power at the begin over the noise's
  double whiteness = 0;  ///< of the innovations: N times the sum of squared autocorrelations at
                         ///< lags 1 to 3, gamma of shape 3 where one mode is all there is
  /// A steady tone, or one that decays by less than 10 % over the band's length; its errors are
  /// infinite.
  bool too_slow = false;
};

/// The most likely mode of a band; none where no maximum lies within the bounds: d up to twice the
/// rate, frequencies within 0.3 of the rate.
/// @param room_rate  delta [1/s]
std::optional<ReverberantLine> fit_line(const BandSignal& band, double room_rate);

/// Minus the log-likelihood of a band's samples but the first, which the filter begins with.
/// @param at  omega [rad/s], ln d, ln q, ln R
double line_misfit(const BandSignal& band, double room_rate, std::span<const double, 4> at);

}  // namespace carillon::eval::damping
