#pragma once

#include <Eigen/Geometry>

#include "render/detail/offscreen.hpp"
#include "render/maps/surface_map.hpp"

namespace carillon::render {

/// A map as OpenGL reads it: the values of its B-spline at half a texel's distance (a texel's for
/// maps beyond 1,024), between which the hardware interpolates linearly. Pictures therefore show
/// the surface that motion and sound know, within a fraction of a texel.
struct FaceDetail {
  Texture heights;                    ///< of a relief alone [m]
  Texture slopes;                     ///< with means for where a pixel sees many texels
  Eigen::Vector2d map_size = {1, 1};  ///< [m]
  double grain = 1;                   ///< distance of the samples [m]
  double deepest = 0;                 ///< of a relief: a little more than its depth [m]

  bool relief() const { return deepest > 0; }
};

/// @throws InputError  a map without texels, or with values that are not finite or too many
FaceDetail face_detail(const maps::SurfaceMap& map);

/// (u, v, height above the face) to the body's coordinates.
Eigen::Affine3d body_from_face(const maps::TexturedFace& face);

}  // namespace carillon::render
