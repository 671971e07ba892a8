#pragma once

#include <cstdint>
#include <limits>
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

/// The inward edges of a mesh, ascending; those between plane faces that turn by less than 15
/// degrees are taken for chords of a smooth surface, and others by less than 2 for its
/// approximation.
/// @param mesh  curved elements of any order
std::vector<InwardEdge> inward_edges(const TetMesh& mesh);

/// How an inward edge passes a straight line between two nodes.
struct Passage {
  /// Of the ellipse that has the line's ends as foci and meets the edge, both seen along it: the
  /// sum of its half axes over half of its foci's distance. 1 where the edge meets the line.
  /// Polynomials on the line follow a field that is smooth up to the edge with errors of rho^-order
  /// (Trefethen 2019, theorem 8.2).
  double rho = std::numeric_limits<double>::infinity();
  double share = 0;  ///< of the line before the place that is nearest to the edge
};
Passage passage(const TetMesh& mesh, std::int32_t one, std::int32_t other, const InwardEdge& edge);

/// The inward edge that an element's polynomials suffer most from.
struct NearestEdge {
  double exponent = 1;  ///< of its field, InwardEdge::exponent
  /// The least Passage::rho of the element's edges; infinity where no inward edge is near.
  double rho = std::numeric_limits<double>::infinity();
};

/// For each element.
/// @param mesh  curved elements of any order
std::vector<NearestEdge> nearest_edges(const TetMesh& mesh);

/// Elements whose four corners lie on edges that turn outward by 60 degrees or more: those of a bar
/// that is one element wide and thick.
/// @param mesh  curved elements of any order
std::vector<bool> between_sharp_edges(const TetMesh& mesh);

}  // namespace carillon::solvers::mesh
