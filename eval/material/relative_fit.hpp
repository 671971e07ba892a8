#pragma once

#include "eval/damping/fit_damping.hpp"

namespace carillon::eval::material {

/// A damping law fitted to few points: least squares of ln(c / law), as the errors of decay rates
/// go with the rates, and intervals by profiling with Student's quantile, which hold for three
/// points as for many. Where points are enough to tell excess from error, fit_damping() knows more.
/// @throws InputError  no more points than parameters; and as fit_damping(), which gives the start
damping::DampingFit fit_relative(const damping::DampingData& data, const damping::DampingLaw& law);

/// A damping law fitted to the decay rates of matched modes: fit_relative(), or with room for
/// excess (Estimator::emg_relative) where ten points more than parameters can tell it from error.
/// @throws InputError  as those
damping::DampingFit fit_matched(const damping::DampingData& data, const damping::DampingLaw& law);

}  // namespace carillon::eval::material
