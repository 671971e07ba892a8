#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "solvers/modes/modes.hpp"

namespace carillon::synth::surface {

/// The outer surface of a body in straight triangles whose corners lie on the curved faces, all
/// cut alike. Together they are closed, so that a field without sources inside has no flux through
/// them, and a body that only moves as a whole has no volume velocity.
struct OuterTriangles {
  solvers::mesh::SurfaceMesh mesh;             ///< [m]
  std::vector<std::array<int, 3>> neighbours;  ///< across (01), (12), (20); -1: none
  std::vector<Vec3> centres;                   ///< [m]
  std::vector<Vec3> area_vectors;              ///< outward, as long as the area [m^2]
  std::vector<double> areas;                   ///< [m^2]
  double area = 0;                             ///< of all
  /// Shapes (n x 3 nodes) times this (3 nodes x triangles) is the volume velocity of every mode
  /// through every triangle [m^2].
  Eigen::SparseMatrix<double> flux_weights;

  std::size_t size() const { return mesh.triangles.size(); }
};

/// Cuts each outer face into the fewest n^2 triangles (n at most 12) that give at least `count`.
/// @throws InputError  no outer surface, or one without area or with a node that is not finite
OuterTriangles outer_triangles(const solvers::modes::ModeSurface& surface, std::size_t count);

}  // namespace carillon::synth::surface
