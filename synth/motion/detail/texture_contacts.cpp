#include "synth/motion/detail/texture_contacts.hpp"

#include <array>
#include <set>
#include <utility>

#include "synth/motion/detail/bullet_vectors.hpp"
#include "synth/motion/detail/relief_contacts.hpp"

namespace carillon::synth::motion {

namespace {

/// A textured face where it is now.
struct PlacedFace {
  Eigen::Matrix3d axes;  ///< columns u, v, normal; world
  Vec3 origin;           ///< world [m]

  Vec3 to_face(const Vec3& world) const { return axes.transpose() * (world - origin); }
  Vec3 to_world(const Vec3& face) const { return origin + axes * face; }
};

class Changer {
 public:
  Changer(std::span<const MovingBody> bodies, std::span<const CollisionShape> shapes,
          std::span<const std::shared_ptr<const ReliefPeaks>> peaks,
          std::span<const Eigen::Quaterniond> principal, double unit)
      : bodies_(bodies), shapes_(shapes), peaks_(peaks), principal_(principal), unit_(unit) {}

  void change(btPersistentManifold& manifold) {
    const std::array<const btCollisionObject*, 2> objects = {manifold.getBody0(),
                                                             manifold.getBody1()};
    const auto textured = [&](std::size_t side) {
      return bodies_[static_cast<std::size_t>(objects[side]->getUserIndex())].texture.has_value();
    };
    if (!textured(0) && !textured(1)) return;
    const bool first_is_smaller = objects[0]->getUserIndex() < objects[1]->getUserIndex();
    const std::size_t preferred = first_is_smaller ? 0 : 1;
    for (const std::size_t side : {preferred, 1 - preferred}) {
      if (!textured(side)) continue;
      const Sides sides{objects[side], objects[1 - side], side == 1};
      const render::maps::TexturedFace& texture = *bodies_[number(sides.face)].texture;
      const PlacedFace face = place(sides.face, texture);
      if (!is_touched(manifold, sides, face, texture)) continue;
      if (texture.map->relief()) {
        dip(manifold, sides, face, texture);
      } else {
        tilt(manifold, sides, face, texture);
      }
      return;
    }
  }

 private:
  struct Sides {
    const btCollisionObject* face;   ///< the textured body
    const btCollisionObject* other;  ///< what touches it
    bool face_is_second;             ///< body 1 of the manifold
  };

  static std::size_t number(const btCollisionObject* object) {
    return static_cast<std::size_t>(object->getUserIndex());
  }

  PlacedFace place(const btCollisionObject* object,
                   const render::maps::TexturedFace& texture) const {
    const std::size_t b = number(object);
    const btMatrix3x3& basis = object->getWorldTransform().getBasis();
    Eigen::Matrix3d turn;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) turn(i, j) = basis[i][j];
    }
    turn = turn * principal_[b].conjugate().toRotationMatrix();  // of the body's coordinates
    PlacedFace face;
    face.axes.col(0) = turn * texture.u;
    face.axes.col(1) = turn * texture.v;
    face.axes.col(2) = turn * texture.normal();
    face.origin = unit_ * from_bullet(object->getWorldTransform().getOrigin()) +
                  turn * (texture.origin - bodies_[b].rigid.centre);
    return face;
  }

  static bool within(const Vec3& place, const Eigen::Vector2d& size) {
    return place.x() >= 0 && place.y() >= 0 && place.x() <= size.x() && place.y() <= size.y();
  }

  /// Outward normal of the face's body at a contact.
  static Vec3 outward(const btManifoldPoint& point, const Sides& sides) {
    const Vec3 on_second = from_bullet(point.m_normalWorldOnB);  // from the second into the first
    return sides.face_is_second ? on_second : Vec3(-on_second);
  }

  bool is_on_face(const btManifoldPoint& point, const Sides& sides, const PlacedFace& face,
                  const render::maps::TexturedFace& texture) const {
    const btVector3& on_face =
        sides.face_is_second ? point.m_positionWorldOnB : point.m_positionWorldOnA;
    const Vec3 here = face.to_face(unit_ * from_bullet(on_face));
    return outward(point, sides).dot(face.axes.col(2)) >= on_face_limit &&
           within(here, texture.size);
  }

  /// Whether the bodies meet on the textured face, not on another side of its body.
  bool is_touched(const btPersistentManifold& manifold, const Sides& sides, const PlacedFace& face,
                  const render::maps::TexturedFace& texture) const {
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      if (is_of_relief(point, sides) || is_on_face(point, sides, face, texture)) return true;
    }
    return false;
  }

  /// Normal map: the normal is the map's, a ball is met at c - r n.
  void tilt(btPersistentManifold& manifold, const Sides& sides, const PlacedFace& face,
            const render::maps::TexturedFace& texture) const {
    const MovingBody& other = bodies_[number(sides.other)];
    for (int k = 0; k < manifold.getNumContacts(); ++k) {
      btManifoldPoint& point = manifold.getContactPoint(k);
      if (!is_on_face(point, sides, face, texture)) continue;
      const btVector3& on_face =
          sides.face_is_second ? point.m_positionWorldOnB : point.m_positionWorldOnA;
      const Vec3 here = face.to_face(unit_ * from_bullet(on_face));
      const Vec3 normal =
          face.axes * render::maps::normal_of(render::maps::slope_at(*texture.map, here.head<2>()));
      point.m_normalWorldOnB = to_bullet(sides.face_is_second ? normal : Vec3(-normal));
      if (!(other.ball_radius > 0)) continue;
      const btVector3& centre = sides.other->getWorldTransform().getOrigin();
      const btVector3 met = centre - to_bullet(normal) * (other.ball_radius / unit_);
      (sides.face_is_second ? point.m_positionWorldOnA : point.m_positionWorldOnB) = met;
    }
  }

  /// Relief: contacts on the face are those of the relief.
  void dip(btPersistentManifold& manifold, const Sides& sides, const PlacedFace& face,
           const render::maps::TexturedFace& texture) {
    std::vector<btManifoldPoint> old;
    for (int k = manifold.getNumContacts() - 1; k >= 0; --k) {
      const btManifoldPoint& point = manifold.getContactPoint(k);
      const bool of_the_relief = is_of_relief(point, sides);
      if (!of_the_relief && !is_on_face(point, sides, face, texture)) continue;
      if (of_the_relief) old.push_back(point);
      manifold.removeContactPoint(k);
    }
    // Pieces of one body have a manifold each: the first gets what the body as a whole meets.
    if (!met_.insert({number(sides.face), number(sides.other)}).second) return;
    for (const ReliefContact& contact : contacts_on(face, sides, texture)) {
      add(manifold, sides, face, contact, old);
    }
  }

  std::vector<ReliefContact> contacts_on(const PlacedFace& face, const Sides& sides,
                                         const render::maps::TexturedFace& texture) const {
    const std::size_t b = number(sides.other);
    const ReliefPeaks& peaks = *peaks_[number(sides.face)];
    const btTransform& frame = sides.other->getWorldTransform();
    if (bodies_[b].ball_radius > 0) {
      return ball_on_relief(peaks, texture.size,
                            face.to_face(unit_ * from_bullet(frame.getOrigin())),
                            bodies_[b].ball_radius);
    }
    std::vector<Vec3> points;
    for (const Vec3& p : shapes_[b].hull.vertices) {
      const Vec3 local = principal_[b].conjugate() * (p - bodies_[b].rigid.centre);
      points.push_back(face.to_face(unit_ * from_bullet(frame * to_bullet(local / unit_))));
    }
    return hull_on_relief(peaks, texture.size, points, shapes_[b].hull.triangles);
  }

  void add(btPersistentManifold& manifold, const Sides& sides, const PlacedFace& face,
           const ReliefContact& contact, const std::vector<btManifoldPoint>& old) const {
    const Vec3 normal = face.axes * contact.normal;
    const btVector3 on_other = to_bullet(face.to_world(contact.point) / unit_);
    const btVector3 on_face =
        to_bullet((face.to_world(contact.point) + contact.depth * normal) / unit_);
    const btVector3 first = sides.face_is_second ? on_other : on_face;
    const btVector3 second = sides.face_is_second ? on_face : on_other;
    btManifoldPoint point(manifold.getBody0()->getWorldTransform().invXform(first),
                          manifold.getBody1()->getWorldTransform().invXform(second),
                          to_bullet(sides.face_is_second ? normal : Vec3(-normal)),
                          -contact.depth / unit_);
    point.m_positionWorldOnA = first;
    point.m_positionWorldOnB = second;
    point.m_index0 = mark_of(sides);
    // What pushed here before is where the solver begins.
    for (const btManifoldPoint& was : old) {
      if ((was.m_positionWorldOnB - second).length() * unit_ < 0.1 * radius_of(sides)) {
        point.m_appliedImpulse = was.m_appliedImpulse;
        break;
      }
    }
    manifold.addManifoldPoint(point);
  }

  double radius_of(const Sides& sides) const {
    const std::size_t b = number(sides.other);
    return bodies_[b].ball_radius > 0 ? bodies_[b].ball_radius : shapes_[b].reach;
  }

  /// Marks a contact as one of the relief on this side, beyond any index of Bullet's.
  static int mark_of(const Sides& sides) { return (1 << 20) + (sides.face_is_second ? 1 : 0); }
  static bool is_of_relief(const btManifoldPoint& point, const Sides& sides) {
    return point.m_index0 == mark_of(sides);
  }

  std::span<const MovingBody> bodies_;
  std::span<const CollisionShape> shapes_;
  std::span<const std::shared_ptr<const ReliefPeaks>> peaks_;
  std::span<const Eigen::Quaterniond> principal_;
  double unit_;
  std::set<std::pair<std::size_t, std::size_t>> met_;
};

}  // namespace

void change_textured_contacts(btCollisionDispatcher& dispatcher, std::span<const MovingBody> bodies,
                              std::span<const CollisionShape> shapes,
                              std::span<const std::shared_ptr<const ReliefPeaks>> peaks,
                              std::span<const Eigen::Quaterniond> principal, double unit) {
  Changer changer(bodies, shapes, peaks, principal, unit);
  for (int m = 0; m < dispatcher.getNumManifolds(); ++m) {
    changer.change(*dispatcher.getManifoldByIndexInternal(m));
  }
}

}  // namespace carillon::synth::motion
