#pragma once

#include "synth/motion/motion.hpp"

namespace carillon::synth::motion {

/// @throws InputError  a state, impact or contact that is not finite, or of a body that is not
///                     there; names body and time
void check_finite(const Motion& motion);

}  // namespace carillon::synth::motion
