#pragma once

#include <functional>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// The mesh that a function makes, in a process of its own: what crashes there or never ends does
/// so alone.
/// @param seconds  of processor time that it may take
/// @throws SolverError  with the function's own message, the signal that ended it, or its time
/// @throws std::bad_alloc  memory ran out there
TetMesh made_apart(const std::function<TetMesh()>& make, unsigned seconds);

}  // namespace carillon::solvers::mesh::tetrahedra
