#pragma once

#include "solvers/mesh/curve_mesh.hpp"
#include "solvers/mesh/shape_source.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Remeshes a clean closed surface to sizes that follow local thickness and curvature, features
/// kept (CGAL isotropic remeshing), and fills it by boundary-constrained Delaunay (Gmsh's
/// library): a thin wall gets one layer of wide elements. First-order tetrahedra. Several
/// components and cavities (components that look inward) are allowed.
/// @throws SolverError  Gmsh failed, or more than options.max_elements are needed (names the
///                      element_size that would fit)
TetMesh tetrahedralise(const SurfaceMesh& surface, const MeshOptions& options);

/// Projection on the triangles of a surface (AABB tree).
SurfaceProjection project_to(const SurfaceMesh& surface);

}  // namespace carillon::solvers::mesh::tetrahedra
