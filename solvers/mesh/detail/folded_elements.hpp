#pragma once

#include <cstddef>
#include <vector>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// Elements whose Jacobian falls below a twentieth of the straight element's somewhere.
std::vector<std::size_t> folded_elements(const TetMesh& mesh);

}  // namespace carillon::solvers::mesh
