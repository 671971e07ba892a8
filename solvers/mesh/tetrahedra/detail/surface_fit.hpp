#pragma once

#include "solvers/mesh/tet_mesh.hpp"
#include "solvers/mesh/tetrahedra/surface_search.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Fills in how far a mesh's curved boundary is from the surface that it was made of: volume_error,
/// area_error and hausdorff; `quality` knows the mesh's volume. The distance is sampled at the
/// boundary's nodes, the surface's vertices and points spread evenly over its triangles.
void measure_fit(const TetMesh& mesh, const SurfaceMesh& surface, const SurfaceSearch& search,
                 MeshQuality& quality);

}  // namespace carillon::solvers::mesh::tetrahedra
