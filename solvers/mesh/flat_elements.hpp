#pragma once

#include <cstdint>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// Takes flat first-order elements off the boundary: those whose volume is below 1e-9 of the cube
/// of their longest edge, as a boundary-constrained Delaunay leaves between triangles in one plane.
/// They enclose nothing, so the body stays the same; only those go whose other faces make a proper
/// boundary. Nodes that no element uses any more go too.
/// @return number of elements taken off
std::int64_t peel_flat_elements(TetMesh& mesh);

}  // namespace carillon::solvers::mesh
