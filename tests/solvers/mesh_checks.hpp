#pragma once

#include <string>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::test {

/// What is wrong with a mesh, or "" when nothing is: node numbers in range and all used, positive
/// Jacobians at quadrature points of twice the order, boundary faces recorded, every boundary edge
/// shared by exactly two faces that run along it in opposite directions (whole edges, with the
/// nodes on them), and the volume inside the faces equal to that of the elements.
std::string mesh_faults(const solvers::mesh::TetMesh& mesh);

/// Vertices - edges + faces of the boundary: 2 for a ball, 0 for a ring, 4 for a ball with a
/// cavity.
int boundary_euler_number(const solvers::mesh::TetMesh& mesh);

/// Area of the curved boundary [m^2].
double boundary_area(const solvers::mesh::TetMesh& mesh);
/// Volume inside the curved boundary by the divergence theorem [m^3].
double boundary_volume(const solvers::mesh::TetMesh& mesh);

double longest_edge(const solvers::mesh::TetMesh& mesh);

/// Nodes of the boundary, each once.
std::vector<std::int32_t> boundary_nodes(const solvers::mesh::TetMesh& mesh);

bool same_bytes(const solvers::mesh::TetMesh& a, const solvers::mesh::TetMesh& b);

}  // namespace carillon::test
