#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace carillon::solvers::mesh::readers {

/// A kind of element in Gmsh's MSH format (reference manual, "Node ordering" and MElement.h).
struct MshElementKind {
  int number;  ///< in the file
  int nodes;
  int dimension;
  const char* name;
  int order = 0;  ///< of Lagrange tetrahedra, 1 to 4; 0: no tetrahedron that is read
};

/// Null when the number is unknown.
const MshElementKind* find_msh_element(std::int64_t number);

/// Barycentric lattice points (4-tuples that sum to the order) of Gmsh's tetrahedron, in Gmsh's
/// order of nodes, so that a table lookup leads to tetrahedron_lattice()'s.
std::vector<std::array<int, 4>> gmsh_tetrahedron_lattice(int order);

}  // namespace carillon::solvers::mesh::readers
