#pragma once

namespace carillon::synth::modal {

/// Critical-band rate [Bark]: 13 atan(0.76 f/kHz) + 3.5 atan((f/7.5 kHz)^2) (Zwicker and Terhardt
/// 1980).
double bark(double frequency);

/// Threshold of hearing in quiet [dB re 20 uPa]: 3.64 f^-0.8 - 6.5 exp(-0.6 (f - 3.3)^2) +
/// 1e-3 f^4, f in kHz (Terhardt 1979). Infinite at 0 Hz.
double hearing_threshold(double frequency);

}  // namespace carillon::synth::modal
