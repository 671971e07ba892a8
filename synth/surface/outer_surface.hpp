#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/modes/modes.hpp"

namespace carillon::synth::surface {

/// A straight triangle of a curved face: three of its lattice nodes.
struct FacePiece {
  std::array<int, 3> nodes;                ///< index in triangle_lattice(order)
  std::array<Eigen::Vector3d, 3> corners;  ///< their barycentric coordinates
};

/// The order^2 pieces of a face, oriented like it.
std::vector<FacePiece> face_pieces(int order);

/// A straight triangle of the surface.
struct SurfaceTriangle {
  std::int32_t face = 0;
  std::array<Eigen::Vector3d, 3> corners;  ///< barycentric coordinates on the face
  std::array<Vec3, 3> positions;           ///< [m]
};

/// The outer surface in straight triangles, order^2 to a face; none where there is no surface that
/// looks outward.
std::vector<SurfaceTriangle> outer_pieces(const solvers::modes::ModeSurface& surface);

/// Half the cross product of two sides: along the normal, as long as the area [m^2].
Vec3 area_vector(const SurfaceTriangle& triangle);

/// Nodes of a face, nodes_per_face(order) values.
/// @throws InputError  face out of range
std::span<const std::int32_t> face_nodes(const solvers::modes::ModeSurface& surface,
                                         std::int32_t face);

/// For every face, whether it lies on the outer surface: faces joined by edges belong together,
/// and those that enclose a negative volume bound a cavity from inside.
std::vector<bool> outer_faces(const solvers::modes::ModeSurface& surface);

/// What the air sees of a body as a whole.
struct OuterHull {
  Vec3 centroid = Vec3::Constant(0);  ///< of the volume inside the outer surface [m]
  double radius = 0;                  ///< of the sphere about the centroid that holds it [m]
  /// Integral of each node's shape function times the outward normal over the outer surface [m^2],
  /// 3 * nodes values, xyz together: its product with a mode shape is the mode's volume velocity.
  Eigen::VectorXd volume_weights;
};

/// Exact for the curved faces (the integrand is a polynomial).
/// @throws InputError  no outer surface
OuterHull outer_hull(const solvers::modes::ModeSurface& surface);

}  // namespace carillon::synth::surface
