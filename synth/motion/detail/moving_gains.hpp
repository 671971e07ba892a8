#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "synth/motion/detail/driven_modes.hpp"
#include "synth/motion/motion.hpp"
#include "synth/motion/sounding_body.hpp"

namespace carillon::synth::motion {

/// The dry signal of a moving body: each mode by the root mean square of its normal velocity over
/// the outer surface, so that the row's mean square over time is that of the surface (modes of
/// different pitch do not correlate), wherever the body is touched. One row [m/s].
/// @throws InputError  no outer surface
modal::Readout mean_square_velocity(const solvers::modes::Modes& modes);

/// A body's gains at listeners of the world while it moves: from its fit at key poses, straight
/// lines between.
class MovingGains {
 public:
  /// @param body       its number in the motion
  /// @param listeners  world; none: the dry signal
  /// @param turn       from key to key a listener's direction, as the body sees it, turns by no
  ///                   more [rad], and its distance changes by no larger share
  /// @param moving     false: as at the start, all the time
  /// @throws InputError  listeners, but no fit
  MovingGains(const Motion& motion, std::size_t body, const SoundingBody& sounding,
              std::span<const modal::Listener> listeners, double turn, bool moving);

  /// Over the block from step k to k + 1. Pointers hold until the next call.
  /// @throws InputError  a listener on or in the body; names the time
  DrivenGains over(std::size_t step);

  /// Times of flight from the body's centroid to a listener [s], one per state.
  std::vector<double> flight_times(std::size_t row) const;

  std::uint64_t poses() const { return poses_; }  ///< at which gains were computed

 private:
  Vec3 listener_at(std::size_t step, std::size_t row) const;  ///< body's coordinates
  modal::Readout gains_at(std::size_t step);
  bool near(std::size_t from, std::size_t to, double turn) const;

  const Motion& motion_;
  std::size_t body_;
  const SoundingBody& sounding_;
  std::span<const modal::Listener> listeners_;
  double turn_;
  std::size_t last_;  ///< state
  bool made_ = false;
  bool still_ = true;  ///< between the keys
  std::size_t before_at_ = 0, after_at_ = 0;
  modal::Readout before_, after_;
  std::uint64_t poses_ = 0;
};

}  // namespace carillon::synth::motion
