#pragma once

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh::tetrahedra {

/// Replaces flat first-order elements: those with a dihedral angle near 0 or 180 degrees go
/// together with their neighbours, and what they filled is joined to one new node where the worst
/// angle is best. The boundary stays as it is, so an angle that its faces enclose remains.
void mend_slivers(TetMesh& mesh);

}  // namespace carillon::solvers::mesh::tetrahedra
