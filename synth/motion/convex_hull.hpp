#pragma once

#include <vector>

#include "solvers/mesh/tet_mesh.hpp"

namespace carillon::synth::motion {

/// Empty for points that enclose no volume.
solvers::mesh::SurfaceMesh convex_hull(const std::vector<Vec3>& points);

/// A body as convex pieces that cover it: its tetrahedra are cut into parts of equal number
/// (METIS), as few as make the hulls of the parts hold little more than the body does, and at the
/// most `maximum`. Hulls of neighbours overlap a little.
/// @param excess  of the hulls' volumes over the body's that is allowed
/// @return corners of each piece [m]; one piece for a convex body
std::vector<std::vector<Vec3>> convex_pieces(const solvers::mesh::TetMesh& mesh,
                                             double excess = 0.1, int maximum = 64);

}  // namespace carillon::synth::motion
