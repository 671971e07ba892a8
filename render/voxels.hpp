#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "solvers/mesh/surface_mesh.hpp"

namespace carillon::render {

/// surface: cells that the surface passes through (a face that lies exactly between two cells
/// belongs to the inner one); outer: those and all that cannot be reached from outside through the
/// faces of empty cells (what sight can know); solid: surface and cells whose centre is inside,
/// cavities stay empty.
enum class VoxelFill { surface, outer, solid };

inline constexpr int max_turns = 64;

struct VoxelOptions {
  int resolution = 30;
  VoxelFill fill = VoxelFill::outer;
  double pitch = 0;  ///< cell size [m] of a metric grid; 0: the body's longest side fills the grid
  int turns = 1;     ///< copies, each turned by a further 2 pi / turns about the upright axis, z
};

struct VoxelGrid {
  int resolution = 0;
  double pitch = 0;                 ///< [m]
  Vec3 origin{0, 0, 0};             ///< corner of cell (0, 0, 0) [m]
  std::vector<std::uint8_t> cells;  ///< resolution^3 zeros and ones, index (x * n + y) * n + z
};

/// The body's box lies centred in the grid. `turns` is left aside.
/// @throws InputError  a metric grid is too small for the body (names the pitch that fits), no
///                     faces, no extent, or a resolution outside 1 to 512
VoxelGrid voxelize(const solvers::mesh::SurfaceMesh& mesh, const VoxelOptions& options);

/// `turns` grids of one cell size, of which the first is of the body as it is (Maturana and Scherer
/// 2015: 12 copies, over which a network's answers are pooled). Where the body is to fill the grid,
/// the longest side of any copy does.
/// @throws InputError  as voxelize; turns outside 1 to 64
std::vector<VoxelGrid> voxelize_turned(const solvers::mesh::SurfaceMesh& mesh,
                                       const VoxelOptions& options);

/// @throws InputError  unknown; names the nearest
VoxelFill parse_voxel_fill(const std::string& name);

}  // namespace carillon::render
