#pragma once

#include <functional>
#include <vector>

#include "solvers/surface_mesh.hpp"

namespace carillon::solvers {

/// Edges between faces that meet at more than this are features [degrees].
constexpr double feature_angle_deg = 40;

/// Closed surface with triangles whose edges are about `coarsest` / 2^level, at each place the
/// coarsest level that `wanted_size` allows there (CGAL isotropic remeshing). Feature edges and
/// corners stay. Vertices lie on the input.
/// @param levels       number of halvings, 0: uniform
/// @param wanted_size  largest edge [m] at a point of the surface
SurfaceMesh remesh(const SurfaceMesh& surface, double coarsest, int levels,
                   const std::function<double(const Vec3&)>& wanted_size);

/// Whether two triangles of a surface cross or overlap.
bool intersects_itself(const SurfaceMesh& surface);

}  // namespace carillon::solvers
