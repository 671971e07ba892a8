#pragma once

#include <vector>

#include "solvers/mesh/tetrahedra/detail/surface_search.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// What a surface asks of the triangles that follow it, triangle by triangle.
struct SizeField {
  std::vector<double> area;       ///< [m^2]
  std::vector<double> thickness;  ///< straight in to the side across [m]
  std::vector<double> radius;     ///< of the tighter curvature, features left out [m]
  double volume = 0;              ///< enclosed [m^3]
  double total_area = 0;          ///< [m^2]

  /// Largest edge [m] that follows the surface here: 10 times the wall, 30 degrees of bending and a
  /// sagitta of a third of the wall, for a surface taken to bend `relax` times less than measured.
  double limit(std::size_t triangle, double relax) const;
  /// Triangles and tetrahedra of a mesh with edges of at most `edge`.
  double triangles(double edge, double relax) const;
  double tetrahedra(double edge, double relax) const;
};

/// Wanted edge lengths at the vertices: the tightest limit of the faces around and of feature
/// lines that bend, `coarsest` at most and a sixteenth of it at least,
/// growing by no more than half of the way between.
std::vector<double> vertex_sizes(const SurfaceMesh& surface, const SizeField& field,
                                 double coarsest, double relax);

SizeField measure_sizes(const SurfaceMesh& surface, const SurfaceSearch& search);

}  // namespace carillon::solvers::mesh::tetrahedra
