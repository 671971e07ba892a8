#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "eval/features/feature.hpp"
#include "eval/material/match_ratio.hpp"

namespace carillon::eval::perception {

/// Differences that listeners just notice (JND), in which errors of modes are told.
struct JustNoticeable {
  /// Of lasting tones trained listeners notice 0.2 % (Moore 1973; Wier et al. 1977).
  double pitch = 5;               ///< [cents]
  double damped_pitch = 20;       ///< of short ones [cents]
  double damped_decay_rate = 30;  ///< above which a mode is short [1/s]; both of a pair
  /// Time constants 25 % shorter to 40 % longer sound alike (Tolonen and Jarvelainen 2000): decay
  /// rates up to this factor apart, either way.
  double decay_ratio = 1.33;
  double level = 1;  ///< [dB]
};

/// A mode of one sound as it is in another.
struct MatchedMode {
  std::size_t reference = 0;  ///< place in the reference's features
  std::size_t other = 0;      ///< and in the other's
  double cents = 0;           ///< 1200 log2 of the other's frequency over the reference's
  double decay_ratio = 1;     ///< the other's decay rate over the reference's
  double level = 0;  ///< 20 log10 of the other's amplitude at the onset over the reference's [dB]
  double pitch_jnd = 0;  ///< size of the error over its JND
  double decay_jnd = 0;  ///< NaN where either decay is a room's
  double level_jnd = 0;
  double weight = 0;  ///< geometric mean of the prominences (match_ratio.hpp)
};

/// Errors of one kind over matched modes that can be heard beside the others (weight above 0).
struct JndSummary {
  double mean = 0;   ///< weighted by prominence; NaN for none
  double worst = 0;  ///< NaN for none
};

struct ModeComparison {
  std::vector<MatchedMode> matched;         ///< by the reference's frequency, ascending
  std::vector<std::size_t> reference_only;  ///< ascending places
  std::vector<std::size_t> other_only;
  double reference_fraction =
      0;  ///< of the reference's energy a^2 / (4 d) in matched modes; NaN: none
  double other_fraction = 0;
  /// Energy of what is not matched in either over the energy of both [dB]: -infinity where all is
  /// matched, NaN where there are no modes.
  double unmatched_level = 0;
  JndSummary pitch, decay, level;
};

struct ModeComparisonOptions {
  JustNoticeable jnd;
  material::MatchScale match;
  /// Tones further apart are not the same mode [cents].
  double widest = 100;
  /// After the onset [s]: energies and weights count from there on, so that a mode which is over
  /// before anything of it was recorded, and whose amplitude at the onset is a guess, weighs
  /// little.
  double from = 0;
};

/// Which modes of two sounds are the same, and how far apart they are.
///
/// Each mode has one partner at most; the sum over pairs of their similarity (Sterling 2019, eq.
/// 3.6, in match_ratio.hpp) times their weight is greatest. Level and decay only choose among
/// partners: however far off they are, the pair is matched and the error shows it. Exchanging the
/// sounds changes signs and inverts ratios, nothing else.
/// @throws InputError  a frequency or amplitude that is not positive, or a decay rate that is not
///                     finite
ModeComparison compare_modes(std::span<const features::Feature> reference,
                             std::span<const features::Feature> other,
                             const ModeComparisonOptions& options = {});

}  // namespace carillon::eval::perception
