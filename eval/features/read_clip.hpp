#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "core/audio.hpp"
#include "eval/features/extract_features.hpp"

namespace carillon::eval::features {

/// A channel of a recording by itself.
struct ClipChannel {
  std::size_t number = 0;  ///< from 0
  std::vector<double> samples;
};

/// Those of a clip, the one of most energy first. Of equal ones there is one: the same sound twice
/// has the same noise, and is no second look at it.
std::vector<ClipChannel> channels_by_energy(const core::AudioClip& clip);

/// Features of an audio file. Channels are analysed one by one; a mode that several of them show
/// (rates within three standard errors of each other, or 15 % of half the line's width) becomes one
/// feature: the mean of frequency
/// and decay rate weighted by their errors, amplitude and phase of the channel that hears it
/// loudest. Equal channels are one.
///
/// Onset, begin, end, energy explained and residual are those of the loudest channel.
/// @throws FileError   not readable
/// @throws InputError  a sample that is not finite, options out of range; names the file
FeatureSet read_features(const std::filesystem::path& path, const FeatureOptions& options);

/// One set from those of several channels.
FeatureSet merge_channels(std::vector<FeatureSet> channels);

}  // namespace carillon::eval::features
