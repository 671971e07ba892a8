#pragma once

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "synth/motion/motion.hpp"

namespace carillon::synth::motion {

/// A contact of one substep, before and after it was solved.
struct SolvedContact {
  std::array<std::size_t, 2> bodies{};  ///< the first has the smaller number
  std::array<Vec3, 2> points;           ///< in each body's coordinates [m]
  Vec3 normal = Vec3::Zero();           ///< world, as it was met, into the first
  Vec3 flat_normal = Vec3::Zero();      ///< likewise, without the texture
  Vec3 impulse = Vec3::Zero();          ///< on the first body [N s]
  Vec3 slip = Vec3::Zero();             ///< of the first body's point against the second's [m/s]
  double approach = 0;                  ///< speed at the surfaces before [m/s]
  double begun = 0;                     ///< how long before the substep's begin they touched [s]
};

/// Bodies in Bullet, whose unit of length here is that of the bodies: Bullet's tolerances are meant
/// for bodies of about 1.
class BulletWorld {
 public:
  BulletWorld(std::span<const MovingBody> bodies, std::span<const MotionString> strings,
              const MotionOptions& options);
  ~BulletWorld();
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  /// Bodies that are in one another at the start.
  /// @param step  of the motion [s]
  std::vector<Overlap> overlaps(double step);
  /// Finds the forces of what rests at the start, which the solver only knows after some steps:
  /// steps of this length, after each of which everything is put back. Nothing where nothing
  /// touches.
  void settle(double step);
  void step(double seconds);
  BodyState state(std::size_t body) const;
  /// Contacts that pushed in the last step.
  const std::vector<SolvedContact>& contacts() const;
  /// Mean tension of each string in the last step [N].
  std::vector<double> tensions() const;
  /// Parts into which a step must be cut so that nothing moves too far in one.
  int parts(double seconds) const;
  /// Lets go of a body that was held, with the velocity and spin of its start.
  void release(std::size_t body);
  /// Takes a body out: it stays where it is and touches nothing.
  void take_out(std::size_t body);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace carillon::synth::motion
