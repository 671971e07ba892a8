#pragma once

#include <span>
#include <vector>

#include "eval/features/feature.hpp"

namespace carillon::eval::material {

/// A feature in the dimensions in which features are compared.
struct FeaturePlace {
  double bark = 0;           ///< critical-band rate of the frequency
  double duration = 0;       ///< logarithm of 1 / d plus the shortest duration that matters
  double level = 0;          ///< of the amplitude [dB]
  bool reverberant = false;  ///< the duration is the room's: it is not compared
  double prominence = 0;     ///< weight; only ratios of weights matter
};

/// How far two features may lie apart before half of their similarity is gone, one dimension at a
/// time.
struct MatchScale {
  double bark = 0.1;                ///< 1.6 % of 1 kHz
  double duration = 0.3;            ///< of the logarithm: a factor of 1.35
  double level = 10;                ///< [dB]: amplitudes depend on much that is not known
  double shortest_duration = 2e-3;  ///< [s] bursts that are shorter sound alike
  /// Features this far [dB] below a set's most prominent one weigh nothing.
  double range = 60;
};

/// Energy a^2 / (4 d) of a feature over that of the threshold of hearing at its frequency [dB].
double audible_energy(const features::Feature& feature);

/// Places of features. Prominence is loudness-like: the audible energy over the greatest of the
/// set, to the power 0.23, less that power of the range's end; it does not depend on a common gain.
std::vector<FeaturePlace> places_of(std::span<const features::Feature> features,
                                    const MatchScale& scale);

/// k of Sterling 2019, eq. 3.6: the product of 1 / (1 + D^2) over the dimensions, D the distance in
/// units of the scale; 1 for equal features, falling to 0, symmetric. As a product, so that
/// durations count no less where levels are far off.
double similarity(const FeaturePlace& a, const FeaturePlace& b, const MatchScale& scale);

/// Which of `set` is most similar to a feature, and how much.
struct BestMatch {
  std::size_t index = 0;
  double similarity = 0;
};
/// Point-to-set match ratio (eq. 3.6), whose weights u pick the best match: the mean over others
/// would tell how many others there are. For an empty set 0.
BestMatch best_match(const FeaturePlace& feature, std::span<const FeaturePlace> set,
                     const MatchScale& scale);

/// Set-to-set match ratio (eq. 3.7), weights w the prominences of `from`; 1 for equal sets, 0 where
/// either is empty.
double match_ratio(std::span<const FeaturePlace> from, std::span<const FeaturePlace> to,
                   const MatchScale& scale);

}  // namespace carillon::eval::material
