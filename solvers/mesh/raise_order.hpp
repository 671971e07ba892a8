#pragma once

#include "solvers/elements/node_numbering.hpp"
#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// Numbers of the nodes that the elements of a mesh have at another order: corners first, in the
/// order in which the elements meet them, then as number_nodes() does.
elements::NodeNumbering numbering_at(const TetMesh& mesh, int order);

/// The same curved elements with the nodes of a higher order: a polynomial of a lower degree is
/// one of a higher degree, so the body does not change. No finer_nodes.
TetMesh raise_order(const TetMesh& mesh, int order);

/// The same under another numbering of the nodes, in which each is one of an element.
TetMesh raise_order(const TetMesh& mesh, int order, elements::NodeNumbering numbering);

/// The elements at the next order, nodes on the true surface where mesh.finer_nodes knows them,
/// else on the mesh's own curved elements. Element e is the mesh's element e, with the same
/// corners.
TetMesh next_order(const TetMesh& mesh);

}  // namespace carillon::solvers::mesh
