#include "synth/motion/detail/bullet_world.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "synth/motion/detail/bullet_vectors.hpp"
#include "synth/motion/detail/collision_shape.hpp"
#include "synth/motion/detail/string_constraint.hpp"
#include "synth/motion/detail/texture_contacts.hpp"

namespace carillon::synth::motion {

namespace {

constexpr int iterations = 60;
constexpr int settling_steps = 100;
/// Share of the last step's impulses that the solver begins with. A tower of twenty boxes creeps
/// sideways by 4 mm/s with 0.95 and by 0.15 mm/s with 0.995; with 1 the forces in it never settle.
constexpr double warm_start = 0.995;
/// Depth at which bodies rest in one another [m]: contact neither comes nor goes there.
constexpr double slop = 1e-7;
/// Nearer than so many times the way that gravity takes a body in its first step a contact is
/// solved, though it does not touch yet: else what rests would fall that far and be caught again.
constexpr double nearness = 4;
/// A body moves at the most so much of its thinnest half-extent in a part of a step.
constexpr double longest_way = 0.5;
/// Of the smaller body's reach that two may be in one another at the start unsaid.
constexpr double overlap = 1e-3;

/// Bullet's world with contacts as this house has them: changed after they were found, before they
/// are solved.
class World : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
  std::function<void()> change_contacts;

  void performDiscreteCollisionDetection() override {
    btDiscreteDynamicsWorld::performDiscreteCollisionDetection();
    change_contacts();
  }
};

/// What a contact was before it was solved.
struct Before {
  std::array<btVector3, 2> arms;  ///< from the centres of mass, where the contact is solved
  double approach = 0;            ///< at the surfaces [m/s]
  double begun = 0;               ///< [s]
};

}  // namespace

struct BulletWorld::Impl {
  std::span<const MovingBody> bodies;
  double unit;
  Vec3 gravity;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  World world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<CollisionShape> shapes;
  std::vector<std::shared_ptr<const ReliefPeaks>> peaks;  ///< of reliefs
  std::vector<std::unique_ptr<btRigidBody>> rigid;
  std::vector<Eigen::Quaterniond> principal;
  std::vector<std::unique_ptr<StringConstraint>> strings;
  std::vector<bool> out;
  std::vector<bool> held;  ///< fixed, for ever or until it is let go
  double step = 0;         ///< the one that is under way [s]
  double near;             ///< contacts nearer than this are solved [m]
  std::vector<Before> before;
  std::vector<SolvedContact> solved;

  Impl(std::span<const MovingBody> all, std::span<const MotionString> ropes,
       const MotionOptions& options)
      : bodies(all),
        unit(median_reach(all)),
        gravity(options.gravity),
        out(all.size(), false),
        near(nearness * gravity.norm() * options.time_step * options.time_step) {
    btContactSolverInfo& info = world.getSolverInfo();
    info.m_numIterations = iterations;
    info.m_splitImpulse = 1;
    info.m_splitImpulsePenetrationThreshold = 0;
    info.m_warmstartingFactor = warm_start;
    info.m_linearSlop = slop / unit;
    info.m_restitutionVelocityThreshold = 0;
    info.m_solverMode = SOLVER_SIMD | SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS;
    world.setGravity(to_bullet(gravity / unit));
    world.change_contacts = [this] { change_contacts(); };
    for (std::size_t b = 0; b < bodies.size(); ++b) add(b);
    for (const MotionString& rope : ropes) hang(rope);
  }

  ~Impl() {
    for (const auto& string : strings) world.removeConstraint(string.get());
    for (std::size_t b = 0; b < rigid.size(); ++b) {
      if (!out[b]) world.removeRigidBody(rigid[b].get());
    }
  }

  void add(std::size_t b) {
    const MovingBody& body = bodies[b];
    shapes.push_back(collision_shape(body, unit, near / 2));
    principal.push_back(principal_turn(body.rigid));
    peaks.emplace_back();
    if (body.texture && body.texture->map->relief()) peaks.back() = peaks_of(b);
    const double mass = body.fixed ? 0 : body.rigid.mass;
    const btVector3 inertia =
        body.fixed ? btVector3(0, 0, 0) : to_bullet(body.rigid.inertia / (unit * unit));
    btRigidBody::btRigidBodyConstructionInfo made(mass, nullptr, shapes.back().whole.get(),
                                                  inertia);
    made.m_linearDamping = made.m_angularDamping = 0;
    made.m_additionalDamping = false;
    auto one = std::make_unique<btRigidBody>(made);
    one->setUserIndex(static_cast<int>(b));
    one->setContactProcessingThreshold(near / unit);
    one->setActivationState(DISABLE_DEACTIVATION);
    held.push_back(body.fixed || body.release > 0);
    if (held.back()) {
      one->setLinearFactor({0, 0, 0});
      one->setAngularFactor({0, 0, 0});
    }
    rigid.push_back(std::move(one));
    put_at_start(b);
    world.addRigidBody(rigid.back().get());
  }

  /// Bodies of one map share its peaks.
  std::shared_ptr<const ReliefPeaks> peaks_of(std::size_t b) const {
    for (std::size_t other = 0; other < b; ++other) {
      if (peaks[other] && bodies[other].texture->map == bodies[b].texture->map) return peaks[other];
    }
    return std::make_shared<const ReliefPeaks>(bodies[b].texture->map);
  }

  void put_at_start(std::size_t b) {
    const BodyState& start = bodies[b].start;
    const Eigen::Quaterniond turn = start.pose.turn * principal[b];
    btTransform frame;
    frame.setRotation({turn.x(), turn.y(), turn.z(), turn.w()});
    frame.setOrigin(to_bullet(start.pose.to_world(bodies[b].rigid.centre) / unit));
    btRigidBody& body = *rigid[b];
    body.setWorldTransform(frame);
    body.setInterpolationWorldTransform(frame);
    if (held[b]) return;
    body.setLinearVelocity(to_bullet(start.velocity / unit));
    body.setAngularVelocity(to_bullet(start.spin));
    body.updateInertiaTensor();
  }

  void hang(const MotionString& rope) {
    const MovingBody& body = bodies[rope.body];
    const double length =
        rope.length > 0 ? rope.length : (body.start.pose.to_world(rope.at) - rope.anchor).norm();
    const Vec3 at = principal[rope.body].conjugate() * (rope.at - body.rigid.centre);
    strings.push_back(std::make_unique<StringConstraint>(
        *rigid[rope.body], to_bullet(at / unit), to_bullet(rope.anchor / unit), length / unit));
    strings.back()->enableFeedback(true);
    world.addConstraint(strings.back().get());
  }

  Pose pose(std::size_t b) const {
    const btTransform& frame = rigid[b]->getCenterOfMassTransform();
    const btQuaternion q = frame.getRotation();
    Pose pose;
    pose.turn = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()) * principal[b].conjugate();
    pose.turn.normalize();
    pose.origin = unit * from_bullet(frame.getOrigin()) - pose.turn * bodies[b].rigid.centre;
    return pose;
  }

  /// Visits contacts that touch, with the bodies' numbers as Bullet has them.
  template <class Visit>
  void each_contact(const Visit& visit) {
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
      btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        btManifoldPoint& point = manifold.getContactPoint(k);
        if (point.getDistance() > near / unit) {
          point.m_appliedImpulse = point.m_appliedImpulseLateral1 = point.m_appliedImpulseLateral2 =
              0;
          continue;
        }
        visit(manifold, point);
      }
    }
  }

  static std::size_t number(const btCollisionObject* object) {
    return static_cast<std::size_t>(object->getUserIndex());
  }

  void change_contacts() {
    take_off_skins();
    change_textured_contacts(dispatcher, bodies, shapes, peaks, principal, unit);
    before.clear();
    each_contact([&](btPersistentManifold& manifold, btManifoldPoint& point) {
      const std::size_t a = number(manifold.getBody0()), b = number(manifold.getBody1());
      before.push_back(meet(a, b, point));
    });
  }

  /// Bullet finds distances anew in each step.
  void take_off_skins() {
    for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
      btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
      const double skins =
          shapes[number(manifold.getBody0())].skin + shapes[number(manifold.getBody1())].skin;
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        manifold.getContactPoint(k).m_distance1 += skins / unit;
      }
    }
  }

  Vec3 fall_of(std::size_t b) const { return held[b] ? Vec3(Vec3::Zero()) : gravity; }

  Vec3 velocity_at(std::size_t b, const btVector3& arm) const {
    return unit * from_bullet(rigid[b]->getVelocityInLocalPoint(arm));
  }

  /// Friction of the pair, and a rebound as it would be at the surfaces, where the bodies were a
  /// moment ago. Velocities are those of the middle of the step before: half a step of gravity
  /// makes them those of now.
  Before meet(std::size_t a, std::size_t b, btManifoldPoint& point) const {
    point.m_combinedFriction = std::sqrt(bodies[a].friction * bodies[b].friction);
    point.m_combinedRollingFriction =
        (bodies[a].rolling_friction + bodies[b].rolling_friction) / unit;
    const Vec3 normal = from_bullet(point.m_normalWorldOnB);
    Before met;
    met.arms = {point.getPositionWorldOnA() - rigid[a]->getCenterOfMassPosition(),
                point.getPositionWorldOnB() - rigid[b]->getCenterOfMassPosition()};
    const Vec3 relative = velocity_at(a, met.arms[0]) - velocity_at(b, met.arms[1]);
    const double fall = (fall_of(a) - fall_of(b)).dot(normal);
    const double now = -relative.dot(normal) - fall * step / 2;  // approach
    const double depth = -unit * point.getDistance();
    point.m_combinedRestitution = 0;
    if (!(now > 0)) return met;
    const double square = now * now + 2 * fall * depth;
    met.approach = std::sqrt(std::max(square, 0.0));
    met.begun = std::clamp(depth / now, -step, step);
    const double bounce = std::sqrt(bodies[a].restitution * bodies[b].restitution);
    // Slower than a few steps of gravity no rebound lasts a step.
    if (met.approach < 4 * gravity.norm() * step) return met;
    // Up to the depth at rest Bullet lets them come nearer yet, and takes that off the rebound.
    const double sinking = std::max(0.0, slop - depth) / step;
    const double after = bounce * met.approach + fall * step / 2 + sinking;
    const double solvers = now - fall * step / 2;  // the approach that Bullet multiplies
    if (after > 0 && solvers > 0) point.m_combinedRestitution = after / solvers;
    return met;
  }

  void collect() {
    solved.clear();
    std::size_t index = 0;
    each_contact([&](btPersistentManifold& manifold, btManifoldPoint& point) {
      const Before& was = before[index++];
      if (!(point.m_appliedImpulse > 0)) return;
      SolvedContact contact;
      contact.bodies = {number(manifold.getBody0()), number(manifold.getBody1())};
      const btVector3 impulse = point.m_normalWorldOnB * point.m_appliedImpulse +
                                point.m_lateralFrictionDir1 * point.m_appliedImpulseLateral1 +
                                point.m_lateralFrictionDir2 * point.m_appliedImpulseLateral2;
      contact.impulse = unit * from_bullet(impulse);
      contact.normal = from_bullet(point.m_normalWorldOnB);
      contact.slip =
          velocity_at(contact.bodies[0], was.arms[0]) - velocity_at(contact.bodies[1], was.arms[1]);
      contact.points = {local(contact.bodies[0], point.m_localPointA),
                        local(contact.bodies[1], point.m_localPointB)};
      contact.flat_normal = without_texture(contact.bodies, contact.normal);
      contact.approach = was.approach;
      contact.begun = was.begun;
      if (contact.bodies[0] > contact.bodies[1]) {
        std::swap(contact.bodies[0], contact.bodies[1]);
        std::swap(contact.points[0], contact.points[1]);
        contact.impulse = -contact.impulse;
        contact.normal = -contact.normal;
        contact.flat_normal = -contact.flat_normal;
        contact.slip = -contact.slip;
      }
      solved.push_back(contact);
    });
  }

  /// The textured face's own normal where a contact's is near it.
  Vec3 without_texture(const std::array<std::size_t, 2>& pair, const Vec3& normal) const {
    for (const std::size_t b : pair) {
      if (!bodies[b].texture) continue;
      const Vec3 flat = pose(b).turn * bodies[b].texture->normal();
      if (std::abs(flat.dot(normal)) >= on_face_limit)
        return flat.dot(normal) > 0 ? flat : Vec3(-flat);
    }
    return normal;
  }

  /// From the frame of the principal axes to the body's coordinates.
  Vec3 local(std::size_t b, const btVector3& point) const {
    return bodies[b].rigid.centre + principal[b] * (unit * from_bullet(point));
  }
};

BulletWorld::BulletWorld(std::span<const MovingBody> bodies, std::span<const MotionString> strings,
                         const MotionOptions& options)
    : impl_(std::make_unique<Impl>(bodies, strings, options)) {}

BulletWorld::~BulletWorld() = default;

std::vector<Overlap> BulletWorld::overlaps(double step) {
  impl_->step = step;
  impl_->world.performDiscreteCollisionDetection();
  std::map<std::array<std::size_t, 2>, double> depths;
  impl_->each_contact([&](btPersistentManifold& manifold, btManifoldPoint& point) {
    const std::size_t a = Impl::number(manifold.getBody0()), b = Impl::number(manifold.getBody1());
    double& depth = depths[{std::min(a, b), std::max(a, b)}];
    depth = std::max(depth, -impl_->unit * point.getDistance());
  });
  std::vector<Overlap> found;
  for (const auto& [pair, depth] : depths) {
    const double smaller = std::min(impl_->shapes[pair[0]].reach, impl_->shapes[pair[1]].reach);
    if (depth > overlap * smaller) found.push_back({pair, depth});
  }
  return found;
}

void BulletWorld::settle(double step) {
  for (int k = 0; k < settling_steps; ++k) {
    this->step(step);
    for (std::size_t b = 0; b < impl_->rigid.size(); ++b) impl_->put_at_start(b);
    if (impl_->solved.empty()) return;
  }
}

void BulletWorld::step(double seconds) {
  impl_->step = seconds;
  impl_->world.stepSimulation(seconds, 0);
  impl_->collect();
}

BodyState BulletWorld::state(std::size_t body) const {
  const btRigidBody& rigid = *impl_->rigid[body];
  BodyState state;
  state.pose = impl_->pose(body);
  state.velocity = impl_->unit * from_bullet(rigid.getLinearVelocity());
  state.spin = from_bullet(rigid.getAngularVelocity());
  return state;
}

const std::vector<SolvedContact>& BulletWorld::contacts() const {
  return impl_->solved;
}

std::vector<double> BulletWorld::tensions() const {
  std::vector<double> forces;
  for (const auto& string : impl_->strings) {
    forces.push_back(impl_->unit * string->getAppliedImpulse() / impl_->step);
  }
  return forces;
}

int BulletWorld::parts(double seconds) const {
  double maximum = 1;
  for (std::size_t b = 0; b < impl_->rigid.size(); ++b) {
    if (impl_->held[b] || impl_->out[b]) continue;
    const CollisionShape& shape = impl_->shapes[b];
    const BodyState now = state(b);
    const double turning = impl_->bodies[b].ball_radius > 0 ? 0 : now.spin.norm() * shape.reach;
    const double way = (now.velocity.norm() + turning) * seconds;
    maximum = std::max(maximum, way / (longest_way * shape.thinnest));
  }
  return static_cast<int>(std::min<double>(std::ceil(maximum), max_substep_count + 1.0));
}

void BulletWorld::release(std::size_t body) {
  if (impl_->bodies[body].fixed || !impl_->held[body]) return;
  impl_->held[body] = false;
  btRigidBody& rigid = *impl_->rigid[body];
  rigid.setLinearFactor({1, 1, 1});
  rigid.setAngularFactor({1, 1, 1});
  const BodyState& start = impl_->bodies[body].start;
  rigid.setLinearVelocity(to_bullet(start.velocity / impl_->unit));
  rigid.setAngularVelocity(to_bullet(start.spin));
}

void BulletWorld::take_out(std::size_t body) {
  if (impl_->out[body]) return;
  impl_->out[body] = true;
  impl_->world.removeRigidBody(impl_->rigid[body].get());
}

}  // namespace carillon::synth::motion
