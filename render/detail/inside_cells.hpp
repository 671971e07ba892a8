#pragma once

#include <cstdint>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::render {

/// Which cell centres of a cubic grid lie inside a closed surface: the winding number along a line
/// through the centre is not zero, so that cavities are outside. Lines run along all three axes and
/// the majority decides, which steadies surfaces with small faults. A line that meets an edge or a
/// corner counts it once (ties broken as in rasterisation), so no ray needs to be moved.
///
/// @param vertices    in cells: the grid spans [0, n]^3
/// @return n^3 zeros and ones, index (x * n + y) * n + z
std::vector<std::uint8_t> cells_inside(const std::vector<Vec3>& vertices,
                                       const std::vector<solvers::mesh::Triangle>& triangles,
                                       int n);

}  // namespace carillon::render
