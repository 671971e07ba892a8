#pragma once

#include <span>

#include "eval/features/extract_features.hpp"

namespace carillon::eval::damping {

/// Modes of a sound that was recorded in a room of known reverberation time, those that decay
/// faster than the room among them: from each line of the spectrum the decay rate that is most
/// likely where the room's tail is Gaussian noise of its own decay (ReverberantLine). Amplitudes
/// and phases are not known. What is heard later than 5.8 reverberation times is not looked at.
/// @param samples  full scale 1
/// @param options  as of extract_features(), its rt60 that of a room that reverberates (octaves
/// that
///                 do not are passed over); min_level is the power of a line's peak against the
///                 highest; method, keep_reverberant and explained have no effect
/// @return features by frequency, ascending. Errors are the standard errors of the observed Fisher
///         information times 1.5, and 2 % of d: so far early reflections and doublets are from the
///         model, as measured on sounds whose modes are known (docs/damping.md). Modes whose rate
///         is not told within 30 % are left out; those too slow to be told are counted in a remark.
///         What decays slower than min_decay_rate is in hums, its amplitude not known. Energies are
///         not explained, and there is no residual.
/// @throws InputError  as extract_features(); a room that does not reverberate
features::FeatureSet reverberant_modes(std::span<const double> samples, double sample_rate,
                                       const features::FeatureOptions& options);

}  // namespace carillon::eval::damping
