#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "synth/surface/outer_triangles.hpp"

namespace carillon::synth::surface {

/// A closed surface of triangles in patches of about equal size that do not run around sharp edges.
struct SurfacePatches {
  std::vector<std::vector<int>> members;                 ///< triangles of each patch
  std::vector<std::vector<std::array<int, 2>>> outline;  ///< its border: edges of vertices, outward
  std::vector<Vec3> centres;                             ///< means over the patches [m]
  std::vector<Vec3> normals;                             ///< mean outward unit normals
  std::vector<double> areas;                             ///< [m^2]
  std::vector<double> radii;                             ///< about the centre [m]
  double spacing = 0;                                    ///< sqrt(area / patches) [m]

  std::size_t size() const { return members.size(); }
};

/// Cells of points that are as far from each other as can be, by way over the surface, where a turn
/// of 90 degrees is as long as a patch.
SurfacePatches surface_patches(const OuterTriangles& surface, std::size_t count);

/// Smooth functions on the surface that sum to one: Shepard's, (1 - d / reach)^2, about `count`
/// points that are as far from each other as can be. d is measured straight, but for turns on the
/// way over the surface, so that the two sides of a wall stay apart.
/// @return triangles x count
Eigen::SparseMatrix<double> smooth_functions(const OuterTriangles& surface, std::size_t count);

/// Radius of the largest ball inside the body that touches each triangle's centre [m]: half the
/// thickness of a wall, the distance from a sharp edge; infinite where no ball is too large.
std::vector<double> inscribed_radii(const OuterTriangles& surface, const SurfacePatches& patches);

/// Distance of a point from the nearest triangle [m].
double distance_from(const solvers::mesh::SurfaceMesh& surface, const Vec3& point);

}  // namespace carillon::synth::surface
