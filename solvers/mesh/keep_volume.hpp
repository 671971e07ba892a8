#pragma once

#include "solvers/mesh/curve_mesh.hpp"

namespace carillon::solvers::mesh {

/// Moves the boundary of a mesh along its normals, by about what its curved faces are off the true
/// surface, until the elements have a volume; finer_nodes likewise. Plane faces stay in their
/// planes, and no element folds. A mesh for which no such move is found stays as it is.
/// @param wanted  [m^3]
/// @return the volume that was added to the mesh, as a part of `wanted`
double keep_volume(TetMesh& mesh, double wanted, const SurfaceProjection& truth);

}  // namespace carillon::solvers::mesh
