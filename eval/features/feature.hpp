#pragma once

#include <span>
#include <vector>

namespace carillon::eval::features {

/// One mode of vibration as a recording shows it: a exp(-d t) cos(2 pi f t + phase), t from the
/// onset of the sound. Errors are one standard deviation, from the noise around the mode
/// (Cramer-Rao); those of a method that gives none are NaN.
struct Feature {
  double frequency = 0;         ///< damped, f [Hz]
  double decay_rate = 0;        ///< d [1/s]
  double amplitude = 0;         ///< a at the onset, in the recording's unit (full scale 1)
  double phase = 0;             ///< [rad]
  double frequency_error = 0;   ///< [Hz]
  double decay_rate_error = 0;  ///< [1/s]
  double amplitude_error = 0;
  double snr = 0;  ///< energy of the mode over that of the noise within the mode's own time and
                   ///< bandwidth [dB]
  /// Decays faster than the room that it was recorded in, or cannot be told from the room's own
  /// decays: not to be relied on.
  bool reverberant = false;
  int channel = 0;  ///< of the recording, from 0; where channels were analysed one by one
};

/// lambda = omega_n^2 = (2 pi f)^2 + d^2 [rad^2/s^2] (Sterling 2019, eq. 4.2).
double eigenvalue(const Feature& feature);

/// Decay rate of a room's sound [1/s]: ln(1000) / RT60 in the octave of a frequency.
/// @param rt60  reverberation times by octave from 125 Hz on [s], the last one holds above; not
///              empty; 0: does not reverberate
double room_decay_rate(std::span<const double> rt60, double frequency);

/// Whether any octave of a room reverberates.
/// @param rt60  as room_decay_rate() has it; empty: no room
bool reverberates(std::span<const double> rt60);

}  // namespace carillon::eval::features
