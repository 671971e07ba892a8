#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::render::maps {

/// Detail of a flat face, as one image describes it: a normal map (slopes alone) or a relief map
/// (depth, cut into the face). Motion, sound, touch and pictures all read this one.
///
/// u runs to the right of the picture, v upwards, both [m] from the map's lower left corner; texel
/// (i, j) has its centre at ((i + 1/2) texel, (j + 1/2) texel). Heights are above the face, along
/// its outward normal: never above 0.
///
/// Between texels the surface is the uniform cubic B-spline whose control points the texels are: it
/// has two continuous derivatives and never leaves the range of the texels around (no overshoot at
/// a step, which becomes a slope two texels wide). A sinusoid of n texels a wave comes out
/// sinc(1/n)^4 as deep.
struct SurfaceMap {
  std::string name;
  int width = 0, height = 0;   ///< [texel], each at least 4
  double texel = 0;            ///< side of a texel [m]
  bool repeats = true;         ///< beyond its edges: again and again; else the edge's texels go on
  std::vector<float> heights;  ///< relief [m], <= 0, row by row from v = 0; empty: none
  std::vector<float> slopes_u, slopes_v;  ///< normal map: dh/du, dh/dv; empty on a relief

  bool relief() const { return !heights.empty(); }
  Eigen::Vector2d size() const { return {width * texel, height * texel}; }  ///< [m]
};

/// What the detail is at a place. A normal map has no height: it is 0 all over.
struct SurfaceDetail {
  double height = 0;                                    ///< [m]
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();      ///< dh/du, dh/dv
  Eigen::Matrix2d curvature = Eigen::Matrix2d::Zero();  ///< d slope / d (u, v) [1/m], as it comes
};
SurfaceDetail detail_at(const SurfaceMap& map, const Eigen::Vector2d& uv);
double height_at(const SurfaceMap& map, const Eigen::Vector2d& uv);
Eigen::Vector2d slope_at(const SurfaceMap& map, const Eigen::Vector2d& uv);

/// Unit normal (-dh/du, -dh/dv, 1) / |.| in the face's own axes.
inline Vec3 normal_of(const Eigen::Vector2d& slope) {
  return Vec3(-slope.x(), -slope.y(), 1).normalized();
}

/// Normal of the nearest texel, with steps from texel to texel, as the papers sample it.
Vec3 texel_normal(const SurfaceMap& map, const Eigen::Vector2d& uv);

/// Height of the lowest point of a ball of this radius [m] that rests on the surface above (or, in
/// the plane, at) uv: max over rho of h(uv + rho) + sqrt(r^2 - rho^2) - r, the surface as a tip of
/// that radius traces it (ISO 16610-41's morphological closing is what is left of it). A radius of
/// 0 is the surface itself. Of a normal map the integrated heights count (integrated_relief()),
/// made anew at each call: where many places are asked for, traced_map() is made once.
/// @throws InputError  a radius that is negative or no number
double traced_height(const SurfaceMap& map, const Eigen::Vector2d& uv, double radius);

/// The relief that a ball's lowest point follows: its height_at() is traced_height(), exact at the
/// centres of the texels; between them, where the ball drops from one contact to the next, within
/// a sixth of a texel times the change of slope there.
/// @throws InputError  a radius that is negative or no number
SurfaceMap traced_map(const SurfaceMap& map, double radius);

/// The relief whose slopes are nearest to a normal map's in the mean square (Frankot and Chellappa
/// 1988, with the B-splines of both as their basis functions), shifted so that its highest texel is
/// 0. Where the map does not repeat it is mirrored for the transform. Of a relief, itself.
SurfaceMap integrated_relief(const SurfaceMap& map);

/// The normal map of a relief: slopes of its B-spline at the texels.
SurfaceMap normal_map_of(const SurfaceMap& relief);

/// Where a map lies on a body: a rectangle in the body's coordinates.
struct TexturedFace {
  std::shared_ptr<const SurfaceMap> map;  ///< of all faces and bodies that have it
  Vec3 origin = Vec3::Zero();             ///< where u = v = 0 [m]
  Vec3 u = Vec3::UnitX();                 ///< unit vectors
  Vec3 v = Vec3::UnitY();
  Eigen::Vector2d size = {0, 0};  ///< of the rectangle [m]; the map repeats or goes on inside it
  Vec3 normal() const { return u.cross(v); }  ///< outward
};

}  // namespace carillon::render::maps
