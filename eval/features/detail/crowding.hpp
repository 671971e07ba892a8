#pragma once

#include <cstddef>
#include <span>

#include "eval/features/feature.hpp"

namespace carillon::eval::features {

/// How many other modes as strong as this one are to be expected within its line, from the density
/// of those around: each counts with a Lorentzian five lines wide, and by the height of its line a
/// / d beside this one's where it is lower. 1 at most.
/// @param features  modes of one sound; a line is d / pi wide
double crowding(std::span<const Feature> features, std::size_t index);

/// Adds to the errors of modes what others make that noise hides. Where lines overlap, a sum of two
/// modes may be one as far as the noise lets anyone see, off by the root of what the noise leaves
/// open: cos(D t / 2) exp(-d t) differs from exp(-d t) by D^2 / (16 d^2) of it. How large a part of
/// the line that comes to, beside its crowding, is measured on sums of modes drawn at random
/// (docs/features.md). A decay rate that was known to within itself still is.
void widen_crowded(std::span<Feature> features);

}  // namespace carillon::eval::features
