#include "synth/motion/detail/string_constraint.hpp"

namespace carillon::synth::motion {

namespace {

/// Share of an overlong string that is taken back in a step: little, as it is done by velocity.
constexpr btScalar correction = 0.05;

}  // namespace

StringConstraint::StringConstraint(btRigidBody& body, const btVector3& at, const btVector3& anchor,
                                   btScalar length)
    : btTypedConstraint(MAX_CONSTRAINT_TYPE, body), at_(at), anchor_(anchor), length_(length) {
  enableFeedback(false);
}

void StringConstraint::getInfo1(btConstraintInfo1* info) {
  info->m_numConstraintRows = 1;
  info->nub = 0;
}

void StringConstraint::getInfo2(btConstraintInfo2* info) {
  const btTransform& frame = m_rbA.getCenterOfMassTransform();
  const btVector3 arm = frame.getBasis() * at_;
  const btVector3 along = anchor_ - (frame.getOrigin() + arm);
  const btScalar distance = along.length();
  const btVector3 pull = distance > SIMD_EPSILON ? along / distance : btVector3(0, 0, 1);
  const btVector3 turn = arm.cross(pull);
  for (int k = 0; k < 3; ++k) {
    info->m_J1linearAxis[k] = pull[k];
    info->m_J1angularAxis[k] = turn[k];
  }
  // The string's end may move away by what is slack, and comes back by what is too long.
  const btScalar slack = length_ - distance;
  info->m_constraintError[0] = -slack * info->fps * (slack > 0 ? btScalar(1) : correction);
  info->m_lowerLimit[0] = 0;
  info->m_upperLimit[0] = SIMD_INFINITY;
}

}  // namespace carillon::synth::motion
