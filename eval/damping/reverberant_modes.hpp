#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "eval/features/extract_features.hpp"

namespace carillon::eval::damping {

struct ReverberantOptions {
  std::optional<double> onset;   ///< [s] where the strike begins; none: it is found
  double contact_time = 0.003;   ///< after the onset, left out [s]
  double min_frequency = 20;     ///< [Hz]
  double max_frequency = 20000;  ///< [Hz]
  double min_level = -40;        ///< power of a line's peak against the highest [dB]
  std::size_t max_features = 100;
};

/// Those of an extraction that concern reverberant_modes(), too.
ReverberantOptions reverberant_options(const features::FeatureOptions& options);

/// Why a sound in a room has no features.
inline constexpr const char* no_reverberant_mode =
    "no line of the spectrum whose decay can be told from the noise and the room";

/// Modes of a sound that was recorded in a room of known reverberation time, those that decay
/// faster than the room among them: from each line of the spectrum the decay rate that is most
/// likely where the room's tail is Gaussian noise of its own decay (ReverberantLine). Amplitudes
/// and phases are not known. What is heard later than 5.8 reverberation times is not looked at.
/// @param samples  full scale 1
/// @param rt60     of the room by octave from 125 Hz on [s], the last one holds above; not empty;
///                 octaves of 0 are passed over
/// @return by frequency, ascending. Errors are the standard errors of the observed Fisher
/// information
///         times 1.5, and 2 % of d: so far early reflections and doublets are from the model, as
///         measured on sounds whose modes are known (docs/damping.md). Modes whose rate is not told
///         within 30 % are left out.
/// @throws InputError  a sample that is not finite, a rate that is not positive, no time
std::vector<features::Feature> reverberant_modes(std::span<const double> samples,
                                                 double sample_rate, std::span<const double> rt60,
                                                 const ReverberantOptions& options = {});

}  // namespace carillon::eval::damping
