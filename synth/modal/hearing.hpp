#pragma once

namespace carillon::synth::modal {

/// Critical-band rate [Bark]: 13 atan(0.76 f/kHz) + 3.5 atan((f/7.5 kHz)^2) (Zwicker and Terhardt
/// 1980).
double bark(double frequency);

/// Threshold of hearing in quiet [dB re 20 uPa]: 3.64 f^-0.8 - 6.5 exp(-0.6 (f - 3.3)^2) +
/// 1e-3 f^4, f in kHz (Terhardt 1979). Infinite at 0 Hz.
double hearing_threshold(double frequency);

/// Level of the excitation that a tone causes `distance` Bark above it, relative to the tone's
/// [dB]: 15.81 + 7.5 (z + 0.474) - 17.5 sqrt(1 + (z + 0.474)^2) (Schroeder, Atal and Hall 1979).
double spreading(double distance);

/// How far below its excitation a tone at a critical-band rate hides others [dB]: 14.5 + z
/// (Johnston 1988, after Hellman).
double masking_offset(double bark);

}  // namespace carillon::synth::modal
