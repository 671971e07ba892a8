#pragma once

#include <vector>

#include "solvers/mesh/tetrahedra/detail/surface_search.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Closed surface whose edges follow a size at each vertex of the input: long edges are split,
/// short ones collapsed, edges flipped towards six neighbours, vertices spread along the surface
/// (Botsch and Kobbelt 2004). Feature lines and corners stay; vertices lie on the input.
/// @param sizes  wanted edge length [m], one for each vertex, varying gently along the surface
/// @throws InputError  the surface is open or not manifold
SurfaceMesh remesh(const SurfaceMesh& surface, const std::vector<double>& sizes,
                   const SurfaceSearch& search);

/// Whether two triangles of a surface cross or overlap.
/// @throws InputError  the surface is open or not manifold
bool intersects_itself(const SurfaceMesh& surface);

}  // namespace carillon::solvers::mesh::tetrahedra
