#pragma once

#include <span>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"
#include "synth/motion/detail/relief_peaks.hpp"

namespace carillon::synth::motion {

/// Where a body dips into a relief, in the face's axes (u, v, height above the face).
struct ReliefContact {
  Vec3 point = Vec3::Zero();    ///< of the body [m]
  Vec3 normal = Vec3::UnitZ();  ///< of the relief there
  double depth = 0;             ///< along the normal [m], > 0
};

/// At the most so many contacts of one pair, as in Bullet's manifolds.
inline constexpr std::size_t max_relief_contacts = 4;

/// The deepest, then those farthest from all that were taken, max_relief_contacts at the most.
std::vector<ReliefContact> spread_out(std::vector<ReliefContact> all);

/// Directional penetration depth (Otaduy et al. 2004; dissertation 5.3.1): the body's lower side is
/// compared with the relief along the face's normal, texel by texel, where it reaches below a
/// block's highest; where it is lower there is contact. Each local minimum of the distance is
/// refined between texels on the relief's spline, where the ball's own slope is that of the relief.
/// The deepest comes first.
/// @param centre  of the ball in the face's axes [m]
/// @param size    of the textured rectangle [m]: nothing beyond it is touched
std::vector<ReliefContact> ball_on_relief(const ReliefPeaks& relief, const Eigen::Vector2d& size,
                                          const Vec3& centre, double radius);

/// The same of a convex body: local minima of the distance at the texels, and its corners between
/// them. Of each block the highest texel stands for those that are alike (all of a flat side on a
/// flat top dip in by the same); the deepest of all texels is always found.
/// @param points     of the hull in the face's axes [m]
/// @param triangles  outward
std::vector<ReliefContact> hull_on_relief(const ReliefPeaks& relief, const Eigen::Vector2d& size,
                                          std::span<const Vec3> points,
                                          std::span<const solvers::mesh::Triangle> triangles);

}  // namespace carillon::synth::motion
