#pragma once

#include <numbers>
#include <vector>

#include "solvers/mesh/tetrahedra/surface_search.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// What a surface asks of the triangles that follow it, triangle by triangle.
struct SizeField {
  std::vector<double> area;       ///< [m^2]
  std::vector<double> thickness;  ///< straight in to the side across [m]
  std::vector<double> radius;     ///< of the tighter curvature, features left out [m]
  double volume = 0;              ///< enclosed [m^3]
  double total_area = 0;          ///< [m^2]
  /// Smallest angle between two faces, on whichever side [rad].
  double sharpest_edge = std::numbers::pi;

  /// Mean thickness [m].
  double wall() const { return 2 * volume / total_area; }
  /// Edge [m] that follows the surface here: 10 times the wall, 30 degrees of bending and a sagitta
  /// of a third of the wall, for a surface taken to bend `relax` times less than measured;
  /// `coarsest` at most and a sixteenth of it at least.
  double edge(std::size_t triangle, double coarsest, double relax) const;
  /// Triangles and tetrahedra of a mesh with such edges.
  double triangles(double coarsest, double relax) const;
  double tetrahedra(double coarsest, double relax) const;
};

/// Wanted edge lengths [m] at the vertices: the smallest of the faces around, with limited growth.
std::vector<double> vertex_sizes(const SurfaceMesh& surface, const SizeField& field,
                                 double coarsest, double relax);

/// Lowers sizes where they grow by more than half of the way between vertices.
void limit_growth(const SurfaceMesh& surface, std::vector<double>& sizes);

SizeField measure_sizes(const SurfaceMesh& surface, const SurfaceSearch& search);

}  // namespace carillon::solvers::mesh::tetrahedra
