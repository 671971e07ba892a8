#pragma once

#include <btBulletDynamicsCommon.h>

namespace carillon::synth::motion {

/// Keeps a point of a body within a length of a place in the world; slack it does nothing.
class StringConstraint : public btTypedConstraint {
 public:
  /// @param at      in the rigid body's frame
  /// @param anchor  world
  StringConstraint(btRigidBody& body, const btVector3& at, const btVector3& anchor,
                   btScalar length);

  void getInfo1(btConstraintInfo1* info) override;
  void getInfo2(btConstraintInfo2* info) override;
  void setParam(int, btScalar, int) override {}
  btScalar getParam(int, int) const override { return 0; }

 private:
  btVector3 at_, anchor_;
  btScalar length_;
};

}  // namespace carillon::synth::motion
