#pragma once

#include <array>

#include "render/detail/drawing.hpp"

namespace carillon::render {

/// A lamp with a rectangle of cloth before it.
struct SoftBox {
  Eigen::Matrix3d axes;   ///< columns: sideways, up, towards the box
  Eigen::Vector2d half;   ///< tangents of half its width and height, as they are seen
  Vec3 light;             ///< irradiance over pi where it falls straight on a surface
  Vec3 radiance() const;  ///< of its cloth
};

/// Light of shading_code.hpp. What a white surface sends back that lies level and in the open is
/// about 1: a fixed exposure.
struct Studio {
  Vec3 sky, floor;               ///< radiance from above and from below the horizon
  std::array<SoftBox, 3> boxes;  ///< key, fill and rim

  /// Irradiance over pi of a level surface, facing up.
  Vec3 on_the_floor() const;
};

/// @param key     unit vector towards the key light; the others stand where they do to it
/// @param radius  angular, of the key's lamp [rad]
/// @param ground  reflectance of the floor
Studio make_studio(const Vec3& key, double radius, const Vec3& ground);

/// Uniforms of shading_code.hpp.
void set_studio(const Program& program, const Studio& studio);

}  // namespace carillon::render
