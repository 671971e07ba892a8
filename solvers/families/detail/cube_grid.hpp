#pragma once

#include <array>

#include "solvers/families/extrude.hpp"

namespace carillon::solvers::families {

/// The surface of a cube cut into cells, for walls that close around a hollow. Its plane points are
/// charts of the six faces; on_cube() says where on the cube they are.
/// @param cells  along x, y and z
PlanarGrid cube_grid(const std::array<int, 3>& cells);

/// Point of the cube [-1, 1]^3 of a plane point of cube_grid().
Vec3 on_cube(const Vec2& chart);

/// Cells of cube_grid().
std::int64_t cube_cells(const std::array<int, 3>& cells);

}  // namespace carillon::solvers::families
