#pragma once

#include <span>
#include <vector>

#include "eval/perception/compare_modes.hpp"

namespace carillon::eval::recorded {

/// Modes of one strike, recorded and synthetic.
struct RecordedTones {
  std::span<const features::Feature> recorded;
  std::vector<features::Feature>
      synthetic;  ///< amplitudes in a unit of their own, the same for all strikes
};

/// The middle of values and how far they spread.
struct Spread {
  double median = 0;  ///< NaN for none, as the others
  double low = 0;     ///< a tenth of the values are below
  double high = 0;    ///< a tenth are above
};

/// Over all strikes; pairs count alike.
struct RecordedSummary {
  std::size_t recorded = 0;   ///< modes
  std::size_t synthetic = 0;  ///< that are not `min_level` below the strike's strongest
  std::size_t matched = 0;
  double matched_by_chance = 0;   ///< pairs_by_chance() of the strikes
  double recorded_fraction = 0;   ///< of the recorded energy a^2 / (4 d) in matched modes, mean
  double synthetic_fraction = 0;  ///< over strikes that have any
  Spread cents;                   ///< synthetic above recorded
  Spread distance;                ///< magnitude of it [cents]
  Spread decay_ratio;             ///< synthetic over recorded
  Spread level_error;             ///< magnitude of MatchedMode::level [dB]
};

struct RecordedComparison {
  /// Of each strike, recorded first. Levels are told after `gain`; places of synthetic modes are
  /// those of `synthetic`.
  std::vector<perception::ModeComparison> strikes;
  std::vector<std::vector<features::Feature>> synthetic;  ///< what was compared, with `gain`
  double gain = 0;  ///< of all strikes alike [recording's unit per synthetic unit]: matched modes'
                    ///< median level is 0 dB
  RecordedSummary all;
};

struct RecordedOptions {
  perception::ModeComparisonOptions modes;
  double min_level = -60;  ///< energy of synthetic modes against their strike's strongest [dB]
};

/// Compares recorded and synthetic modes of several strikes on one object, whose recordings have
/// one unknown gain. Pairs are chosen with a gain that makes the energies of both equal, then again
/// with the gain of the pairs found.
/// @throws InputError  as compare_modes()
RecordedComparison compare_recorded(std::span<const RecordedTones> strikes,
                                    const RecordedOptions& options);

/// Of values in any order.
Spread spread_of(std::span<const double> values);

}  // namespace carillon::eval::recorded
