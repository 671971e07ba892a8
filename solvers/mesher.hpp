#pragma once

#include <functional>

#include "solvers/shape_source.hpp"

namespace carillon::solvers {

/// Nearest point of the true surface; what curved boundary nodes are moved to.
using SurfaceProjection = std::function<Vec3(const Vec3&)>;

/// Remeshes a clean closed surface to sizes that follow local thickness and curvature, features
/// kept (CGAL isotropic remeshing), and fills it by boundary-constrained Delaunay (Gmsh's
/// library): a thin wall gets one layer of wide elements. First-order tetrahedra.
/// @throws SolverError  Gmsh failed, or more than options.max_elements are needed
TetMesh tetrahedralise(const SurfaceMesh& surface, const MeshOptions& options);

/// The same tetrahedra with nodes of a higher order; nodes of boundary edges and faces are moved
/// by `project` (none: straight). Edges between faces that meet at more than 40 degrees stay on
/// the surface too. An element whose Jacobian would turn negative is straightened and counted.
TetMesh elevate(const TetMesh& linear, int order, const SurfaceProjection& project,
                std::int64_t& straightened);

/// Projection on the triangles of a surface (AABB tree).
SurfaceProjection project_to(const SurfaceMesh& surface);

}  // namespace carillon::solvers
