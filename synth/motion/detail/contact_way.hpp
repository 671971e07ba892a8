#pragma once

#include <span>
#include <vector>

#include "synth/motion/motion.hpp"

namespace carillon::synth::motion {

/// Places of a lasting contact on one of its bodies, step by step, as what it sweeps over.
///
/// A ball on a textured face is traced by where its centre is: on a relief it touches beside that.
/// What touches with corners hops, from ridge to ridge or along a side that lies flat: the way
/// between is gone at no more than 1.25 times the speed of sliding and turning, and starts and
/// stops over five steps.
/// @param side  of the contact's bodies
/// @return in the body's coordinates [m]
std::vector<Vec3> contact_way(const Motion& motion, std::span<const MovingBody> bodies,
                              const LastingContact& contact, std::size_t side);

}  // namespace carillon::synth::motion
