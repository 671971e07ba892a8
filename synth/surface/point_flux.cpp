#include "synth/surface/point_flux.hpp"

#include <Eigen/Geometry>

namespace carillon::synth::surface {

Vec3 solid_angle_gradient(const Vec3& a, const Vec3& b, double core) {
  const double la = a.norm(), lb = b.norm();
  const double down = la * lb * (la * lb + a.dot(b));
  // On the edge itself the field has no limit; its principal value is zero.
  if (!(down > 0)) return Vec3::Zero();
  const Vec3 across = a.cross(b);
  const double distance2 = across.squaredNorm() / (b - a).squaredNorm();
  return across * ((la + lb) / down * (distance2 / (distance2 + core * core)));
}

}  // namespace carillon::synth::surface
