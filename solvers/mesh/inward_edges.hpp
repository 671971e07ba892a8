#pragma once

#include <cstdint>
#include <vector>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::solvers::mesh {

/// Exponent alpha of the strongest displacement field r^alpha at an edge between two free faces, by
/// the angle that the body fills there: the least positive root of sin(alpha angle) + alpha
/// sin(angle) (Williams 1952, symmetric field). 1 up to 180 degrees, 0.54 at 270, 0.5 at a crack.
/// @param angle  [rad], 0 to 2 pi
double edge_exponent(double angle);

/// An edge of the boundary at which the body fills more than a half-space.
struct InwardEdge {
  std::int32_t from, to;  ///< nodes, the lower one first
  double exponent;        ///< edge_exponent()
};

/// The inward edges of a mesh, ascending; those that turn by less than 15 degrees are taken for
/// chords of a smooth surface.
/// @param mesh  curved elements of any order
std::vector<InwardEdge> inward_edges(const TetMesh& mesh);

/// What the inward edges at an element's corners let its solution be: the least exponent of those
/// that meet in one of them. 1 for elements at none.
/// @param mesh  curved elements of any order
std::vector<double> edge_exponents(const TetMesh& mesh);

/// Elements whose four corners lie on edges that turn outward by 60 degrees or more: those of a bar
/// that is one element wide and thick.
/// @param mesh  curved elements of any order
std::vector<bool> between_sharp_edges(const TetMesh& mesh);

}  // namespace carillon::solvers::mesh
