#pragma once

#include <cstdint>
#include <optional>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// Refuses meshes that fill some place twice: elements with the same corners, more than two
/// elements at a face, or two that share a face and lie on the same side of it (what a node dragged
/// through its neighbours leaves once the elements are turned the right way). Elements numbered
/// inside out are left to assemble(), which names them.
/// @throws core::SolverError  names the elements and the place
void refuse_overlaps(const TetMesh& mesh);

/// A corner that lies inside a face or an edge of an element of its own component which does not
/// have it as a corner: the field is torn open there.
struct HangingNode {
  std::int32_t node;
  std::int64_t element;  ///< whose face it lies in
};

/// The first hanging node, by the elements' straight faces: within 1e-6 of the face's longest edge.
std::optional<HangingNode> find_hanging_node(const TetMesh& mesh);

}  // namespace carillon::solvers::mesh
