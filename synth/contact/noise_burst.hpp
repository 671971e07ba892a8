#pragma once

#include "core/random.hpp"
#include "synth/modal/contact_force.hpp"

namespace carillon::synth::contact {

/// Hiner's hammer: white noise under a rise and fall, low-passed (Hiner 2024, section 3.2 and
/// appendix A: `en.ar(att, att, trig) * no.noise : fi.lowpass(3, ctoff)`).
struct NoiseBurst {
  double hardness = 0.9;  ///< 0 to 1: rise and fall last 0.011 - 0.01 hardness [s] each
  double size = 0.1;      ///< 0 to 1: the low-pass is at 10000 - 9500 size [Hz]
};

/// Rise, and as long a fall [s].
double burst_attack(const NoiseBurst& burst);
/// Cut-off of the third-order Butterworth low-pass [Hz].
double burst_cutoff(const NoiseBurst& burst);

/// The burst as a force sampled at the audio rate, with 0 at both ends. Noise is uniform. It is
/// scaled so that below the cut-off its power spectrum is 1 on average over draws: it then excites
/// a mode as strongly as an ideal strike of unit impulse does on average, although its own integral
/// is as random as the rest. A cut-off at or above half the sample rate filters nothing.
/// @throws InputError  hardness or size outside [0, 1], a sample rate that is not positive or
///                     above 100 MHz
modal::ContactForce noise_burst(const NoiseBurst& burst, double sample_rate,
                                core::RandomStream& random);

}  // namespace carillon::synth::contact
