#pragma once

#include <span>
#include <vector>

#include "eval/features/extract_features.hpp"

namespace carillon::eval::material {

/// Which feature of which recording.
struct FeatureIndex {
  std::size_t recording = 0;
  std::size_t feature = 0;
};

/// A partial of an object as its recordings show it. Two modes of a pair, beats and the companions
/// that an extraction leaves beside a strong feature lie within 20 cents of each other, and further
/// away the weaker they are (1.5 cents for every dB): they are one tone, at the pitch of the
/// strongest.
struct HeardTone {
  double log_frequency = 0;  ///< of the undamped mode, ln Hz
  double error = 0;          ///< one standard deviation of it
  double level = 0;          ///< signal to noise, against the recording's strongest tone [dB]
  /// Prior probability that it is a mode's at all: strong tones mostly are, of weak ones there are
  /// as many of the room, the support and the noise.
  double certainty = 0;
  /// The strongest feature of each recording that has the tone, the loudest first.
  std::vector<FeatureIndex> heads;
};

/// The tones of one object from recordings of it, by frequency; a tone that several of them have is
/// one. No more than 60, the most certain, down to 45 dB below the strongest of a recording.
std::vector<HeardTone> heard_tones(std::span<const features::FeatureSet> recordings);

}  // namespace carillon::eval::material
