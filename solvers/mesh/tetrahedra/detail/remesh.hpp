#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "solvers/mesh/tetrahedra/detail/size_field.hpp"
#include "solvers/mesh/tetrahedra/surface_search.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Closed surface whose edges follow a size at each vertex of the input: long edges are split,
/// short ones collapsed, edges flipped towards six neighbours, vertices spread along the surface
/// (Botsch and Kobbelt 2004). Feature lines and corners stay; vertices lie on the input.
/// @param sizes  wanted edge length [m], one for each vertex, varying gently along the surface
/// @param fixed  for each vertex, whether it and its edges to other fixed ones stay as they are
/// @throws InputError  the surface is open or not manifold
SurfaceMesh remesh(const SurfaceMesh& surface, const std::vector<double>& sizes,
                   const std::vector<bool>& fixed, const SurfaceSearch& search);

/// Pairs of triangles of a surface that cross or overlap.
/// @throws InputError  the surface is open or not manifold
std::vector<std::pair<std::size_t, std::size_t>> crossings(const SurfaceMesh& surface);

/// A surface remeshed to edges of at most `coarsest` [m] that does not cross itself: around
/// crossings the edges are halved twice, then left as they came.
/// @param relax  by how much less than measured the surface is taken to bend
/// @return nothing where crossings remain
/// @throws InputError  the surface is open or not manifold
std::optional<SurfaceMesh> remesh_apart(const SurfaceMesh& surface, const SizeField& field,
                                        double coarsest, double relax, const SurfaceSearch& search);

}  // namespace carillon::solvers::mesh::tetrahedra
