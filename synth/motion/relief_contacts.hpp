#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/textures/surface_map.hpp"

namespace carillon::synth {

using solvers::Vec3;

/// Where a body dips into a relief, in the face's axes (u, v, height above the face).
struct ReliefContact {
  Vec3 point = Vec3::Zero();    ///< of the body [m]
  Vec3 normal = Vec3::UnitZ();  ///< of the relief there
  double depth = 0;             ///< along the normal [m], > 0
};

/// At the most so many contacts of one pair, as in Bullet's manifolds.
inline constexpr std::size_t kMostReliefContacts = 4;

/// Directional penetration depth (Otaduy et al. 2004; dissertation 5.3.1): the body's lower side is
/// compared with the relief along the face's normal, texel by texel; where it is lower there is
/// contact. Each local minimum of the distance is refined between texels on the relief's spline,
/// where the ball's own slope is that of the relief. The deepest comes first.
/// @param centre  of the ball in the face's axes [m]
/// @param size    of the textured rectangle [m]: nothing beyond it is touched
std::vector<ReliefContact> ball_on_relief(const solvers::SurfaceMap& relief,
                                          const Eigen::Vector2d& size, const Vec3& centre,
                                          double radius);

/// The same of a convex body, whose triangles are rasterised at the map's resolution; of a flat
/// side the contacts are as far apart as there are places.
/// @param points     of the hull in the face's axes [m]
/// @param triangles  3 indices each, outward
std::vector<ReliefContact> hull_on_relief(const solvers::SurfaceMap& relief,
                                          const Eigen::Vector2d& size, std::span<const Vec3> points,
                                          std::span<const std::int32_t> triangles);

}  // namespace carillon::synth
