#pragma once

#include <span>
#include <vector>

#include "eval/features/extract_features.hpp"
#include "eval/material/loudness.hpp"
#include "eval/material/match_ratio.hpp"
#include "eval/material/struck_modes.hpp"

namespace carillon::eval::material {

struct MetricOptions {
  MatchScale match;
  double loudest_level = 80;  ///< that the clip's loudest moment is taken to have [dB re 20 uPa]
  /// Added to Pi_psycho, which is a fraction of the clip's own sum: what it comes to even for the
  /// right material where amplitudes are 6 dB off or a third of the modes is missing. Differences
  /// below tell of amplitudes more than of the material. 0: the papers' metric.
  double min_difference = 0.05;
};

/// A recording as candidates are compared with it; prepared once.
struct Reference {
  SpectrogramGrid grid;
  LoudnessScale loudness_scale;
  std::vector<double> loudness;  ///< [sone/Bark], frames x bands
  double loudness_squared = 0;   ///< sum of the squares
  std::vector<FeaturePlace> places;
  double low = 0;  ///< band of what can be heard [Hz]
  double high = 0;
  MetricOptions options;
};

/// Frames run from the set's `begin` to its `end`; the residual's and the hums' power in each band
/// is the background that candidates are heard before.
/// @param samples  of the recording that the features are from
/// @throws InputError  no features (says why), or a set that does not fit the samples
Reference make_reference(std::span<const double> samples, const features::FeatureSet& set,
                         const MetricOptions& options = {});

struct MetricValue {
  double metric = 0;           ///< to be minimised
  double psychoacoustic = 0;   ///< Pi_psycho over the recording's own sum: 0 equal, 1 silence
  double recording_match = 0;  ///< R(extracted, assumed)
  double candidate_match = 0;  ///< R(assumed, extracted)
};

/// Sterling 2019, eq. 3.5 to 3.9 with the slip of 3.9 mended: (Pi_psycho + min_difference)
/// / (R R). Pi_psycho is the squared difference of specific loudness over frames and bands, as a
/// fraction of the recording's squared loudness. Always finite: candidates with negative damping
/// pay up to eleven times as much.
MetricValue hybrid_metric(const Reference& reference, const HeardCandidate& candidate);

/// The product of the match ratios alone, which is cheap: 1 for equal sets.
double match_ratio_product(const Reference& reference, const HeardCandidate& candidate);

}  // namespace carillon::eval::material
