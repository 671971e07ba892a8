#pragma once

#include <cstddef>

#include "synth/modal/ring_down.hpp"

namespace carillon::synth::modal {

struct ThriftOptions {
  double margin = 10;  ///< [dB] a mode must lie below a threshold to be left out
  double range = 90;   ///< [dB] below the loudest mode, where nothing is heard in dry signals
};

/// What was left out, and how far the clip is off for it.
struct ThriftReport {
  std::size_t left_out = 0;
  std::size_t masked = 0;  ///< of them, those that louder modes hide; the others are too soft
  /// No smaller than the L2 norm of what is missing over the L2 norm of the full clip, worst row.
  double error_bound = 0;
};

/// Takes modes that cannot be heard out of a ring-down:
/// - too soft: their energy within 200 ms (the ear's integration time) is below the threshold of
///   hearing by `margin` in every row of pressures [Pa], or `range` below the loudest mode in
///   other rows, which are not calibrated. Modes that are dead before the first sample or within
///   the contact are so, too;
/// - masked: their amplitude is `margin` below what louder modes hide that decay no faster, by the
///   spreading of Schroeder, Atal and Hall (at most 64 of them, the loudest, whose powers add up).
/// Motion during the contact counts in both. Modes that do not oscillate, nearly do not, or lie at
/// or above half the sample rate stay.
///
/// The bound: what is missing is summed sample by sample during the contact and bounded after it
/// by all products of its modes in closed form (exact within groups of 64, whose norms add up); the
/// full clip is no smaller than the norm of what is kept (all products of its modes, over the
/// samples after the contact) less what is missing there. Where that does not bound it (a clip that
/// is over before the contact, say), and where the contacts of all modes and rows come to more
/// than four million samples, nothing is left out. Where nothing is kept, it is 1.
///
/// @throws InputError  a margin or range that is negative or not finite; what synthesize() refuses
///                     of sizes is not looked at
ThriftReport leave_out_inaudible(RingDown& rings, const ContactForce& force, double sample_rate,
                                 std::size_t count, const ThriftOptions& options);

/// 20 log10 of an error bound [dB], -300 where nothing was left out.
double decibels(double error_bound);

}  // namespace carillon::synth::modal
