#pragma once

#include <span>
#include <string>
#include <vector>

namespace carillon::synth::recording {

/// How a recorder keeps a clip.
enum class Codec { none, mp3, vorbis, opus };

/// In the order of the enumeration.
const std::vector<std::string>& codec_names();

/// What a lossy file makes of a clip: written to memory and read back by libsndfile, resampled to a
/// rate that the codec takes and back where it does not take the clip's own. Full scale is 1.
/// @param compression  0 (largest file) to 0.9, libsndfile's level
/// @throws InputError  a compression outside, a sample that is not finite
/// @throws FileError   libsndfile was built without the codec
void pass_through(Codec codec, double compression, std::span<float> clip, double sample_rate);

}  // namespace carillon::synth::recording
