#pragma once

#include <map>
#include <span>
#include <vector>

#include "synth/motion/detail/bullet_world.hpp"
#include "synth/motion/motion.hpp"

namespace carillon::synth::motion {

/// Mass with which a body opposes an impulse at a point along a direction [kg]; infinite when
/// fixed.
double effective_mass(const MovingBody& body, const Pose& pose, const Vec3& world_point,
                      const Vec3& direction);

/// Sorts solved contacts into strikes and contacts that last.
///
/// A contact is a strike when nothing touched at its place a moment ago and the bodies approach at
/// the least speed or more, or when a contact that was at rest passes on a shock: far more than it
/// has borne so far. Whatever else pushes belongs to a contact that lasts, which ends when nothing
/// has pushed for four steps.
class ContactTracker {
 public:
  ContactTracker(std::span<const MovingBody> bodies, const MotionOptions& options)
      : bodies_(bodies), options_(options) {}

  /// One part of a step.
  /// @param begin    its time [s]
  /// @param states   after it
  void add(std::span<const SolvedContact> contacts, double begin, double length,
           std::span<const BodyState> states);
  /// The recorded step of this number is over.
  void end_step(std::size_t step);
  /// Strikes in order of time, contacts in order of their begin; where places of contact move.
  void finish(Motion& motion);

 private:
  using Pair = std::array<std::size_t, 2>;
  struct Track {
    Vec3 place = Vec3::Zero();  ///< world, when it last pushed
    double last = 0;            ///< end of the part in which it last pushed [s]
    double usual = 0;           ///< force that it bears, a running mean [N]
    ContactStep now;            ///< of the step under way; force is the impulse so far [N s]
    bool pushed = false;        ///< in the step under way
    LastingContact contact;
  };

  Track* find(const SolvedContact& contact, const Vec3& place, double time,
              std::span<const BodyState> states);
  void strike(const SolvedContact& contact, double begin, double speed, double mass);
  double pair_mass(const SolvedContact& contact, const Vec3& place,
                   std::span<const BodyState> states) const;
  double speed_bound(const std::array<std::size_t, 2>& pair,
                     std::span<const BodyState> states) const;
  void end_step(Track& track, std::size_t step) const;
  void close(Track& track);

  std::span<const MovingBody> bodies_;
  MotionOptions options_;
  std::map<Pair, std::vector<Track>> tracks_;
  std::vector<Impact> impacts_;
  std::vector<LastingContact> contacts_;
};

}  // namespace carillon::synth::motion
