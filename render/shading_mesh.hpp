#pragma once

#include <cstdint>
#include <numbers>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::render {

/// Vertices as a graphics pipeline wants them: one normal each, split where the surface has an
/// edge. The body is moved to the origin and scaled to the unit sphere.
struct ShadingMesh {
  std::vector<float> positions;        ///< n x 3
  std::vector<float> normals;          ///< n x 3, unit length
  std::vector<std::uint32_t> indices;  ///< 3 per triangle
  std::vector<std::int32_t> sources;   ///< the mesh's vertex that each one comes from, n
};

/// Faces that meet at more keep their edge [rad].
inline constexpr double default_crease_angle = 40 * std::numbers::pi / 180;

/// Ball that holds a body: centre of its box, farthest vertex.
struct BoundingBall {
  Vec3 centre{0, 0, 0};
  double radius = 0;
};
/// @throws InputError  no faces, no extent, or a vertex that is not finite
BoundingBall bounding_ball(const solvers::mesh::SurfaceMesh& mesh);

/// Normals are means over the faces around a vertex, weighted by their angle there (Thuermer and
/// Wuethrich 1998), over those faces that are joined by edges flatter than `crease_angle`. Vertices
/// at the same place count as one, so that triangle soups look smooth too.
/// @param crease_angle  largest angle between the normals of smoothly joined faces [rad]
ShadingMesh shading_mesh(const solvers::mesh::SurfaceMesh& mesh, const BoundingBall& ball,
                         double crease_angle);

}  // namespace carillon::render
