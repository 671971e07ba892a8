#pragma once

#include <vector>

#include "eval/features/extract_features.hpp"
#include "eval/perception/compare_modes.hpp"
#include "eval/perception/spectral_distance.hpp"

namespace carillon::eval::perception {

/// A sound of one channel, and what was extracted from it.
struct HeardSound {
  std::vector<double> samples;
  features::FeatureSet set;
};

/// Specific loudness of two sounds over time and critical bands.
struct LoudnessDifference {
  double rms = 0;  ///< of the difference, over frames and bands [sone/Bark]
  /// The same over the rms of the two sounds' own: 0 for equal sounds, sqrt(2) for sounds that
  /// share no band and moment, or for one against silence. NaN where neither can be heard.
  double fraction = 0;
  double reference_loudest = 0;  ///< loudness of the loudest frame [sone]
  double other_loudest = 0;
};

/// How different two sounds are to a listener, with numbers in place of one.
struct SoundComparison {
  double seconds = 0;      ///< from both onsets on that were compared
  double sample_rate = 0;  ///< at which: the lower of the two [Hz]
  double level = 0;        ///< energy of the other's over the reference's [dB]; NaN if both silent
  ModeComparison modes;
  LoudnessDifference loudness;
  SpectralDistance spectra;
};

struct SoundComparisonOptions {
  ModeComparisonOptions modes;
  /// That the louder sound's loudest moment is taken to have [dB re 20 uPa].
  double loudest_level = 80;
};

/// Compares two sounds of the same object, e.g. a recording and what was made again from it.
///
/// Their onsets are laid on each other, and what both have from there on is compared, up to the
/// next strike of either. Loudness is Zwicker's (eval/material/loudness.hpp) on one scale for both,
/// so that a gain between them is heard. Symmetric but for signs, ratios and the spectra's first
/// part.
/// @throws InputError  no samples from an onset on, or as compare_modes
SoundComparison compare_sounds(const HeardSound& reference, const HeardSound& other,
                               const SoundComparisonOptions& options = {});

}  // namespace carillon::eval::perception
