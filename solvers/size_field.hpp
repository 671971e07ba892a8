#pragma once

#include <vector>

#include "solvers/surface_search.hpp"

namespace carillon::solvers {

/// What a surface asks of the triangles that follow it, triangle by triangle.
struct SizeField {
  std::vector<double> area;       ///< [m^2]
  std::vector<double> thickness;  ///< straight in to the side across [m]
  std::vector<double> radius;     ///< of the tighter curvature, features left out [m]
  double volume = 0;              ///< enclosed [m^3]
  double total_area = 0;          ///< [m^2]

  /// Largest edge [m] that follows the surface here: `relax` times 30 degrees of bending, but
  /// never more sagitta than a third of the wall.
  double limit(std::size_t triangle, double relax) const;
  /// Triangles and tetrahedra of a mesh with edges of at most `edge`.
  double triangles(double edge, double relax) const;
  double tetrahedra(double edge, double relax) const;
};

SizeField measure_sizes(const SurfaceMesh& surface, const SurfaceSearch& search);

}  // namespace carillon::solvers
