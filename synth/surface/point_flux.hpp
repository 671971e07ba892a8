#pragma once

#include "core/vectors.hpp"

namespace carillon::synth::surface {

/// Share of the edge a -> b of an area's outline in the gradient of the area's solid angle by the
/// place of the observer, who is at the origin (Biot and Savart's law of a straight wire). Within
/// `core` of the wire the field falls to zero: that of an observer smeared out so far.
Vec3 solid_angle_gradient(const Vec3& a, const Vec3& b, double core);

}  // namespace carillon::synth::surface
