#pragma once

#include "synth/modal/contact_force.hpp"

namespace carillon::synth::contact {

/// Force of an elastic Hertz contact of unit impulse, x^(3/2) with x'' = -5/4 x^(3/2) in units of
/// the deepest approach (Johnson 1985, section 11.4), in 128 straight pieces. Its peak is 1.840 /
/// duration. A duration of 0 is an ideal impulse.
/// @throws InputError  as check()
modal::ContactForce hertz_pulse(double duration);

}  // namespace carillon::synth::contact
