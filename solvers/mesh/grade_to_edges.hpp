#pragma once

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// Each layer of grade_to_edges() is so much thinner than the one around it: where elements of
/// orders 2 to 4 gain most by unknown (Babuska and Guo 1988).
constexpr double layer_ratio = 0.2;

/// The same body in elements that crowd geometrically towards its inward edges, where the solution
/// is no polynomial: each layer cuts the elements at such an edge across it, not along it (Apel
/// 1999, anisotropic finite elements; the fields vary little along an edge), and sides of elements
/// that an inward edge passes nearby are cut there first. Pieces of curved elements are curved
/// elements of the same order, so neither body nor surface change. finer_nodes and gaps come along.
/// Lines of edges much smaller than the elements are passed over: spikes of a scan would take most
/// of the layers.
/// @param layers  how often; each multiplies the sizes at the edges by layer_ratio. 0, or no edge:
///                the mesh itself
TetMesh grade_to_edges(const TetMesh& mesh, int layers);

/// Whether a mesh has edges that layers would help.
bool has_edges_to_grade(const TetMesh& mesh);

}  // namespace carillon::solvers::mesh
