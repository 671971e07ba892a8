#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/random.hpp"
#include "render/maps/detail/patterns.hpp"

namespace carillon::render::maps {
namespace {

/// Rectangular blocks with sunk joints between them.
struct Blocks {
  Eigen::Array2d size;  ///< of a block's upper side and its edges, without joint [m]
  double joint = 0;     ///< width [m]
  double depth = 0;     ///< of the joints [m]
  double rounding = 0;  ///< radius of edges and corners [m]
  double unevenness = 0;
  int columns = 0, rows = 0;
  bool shifted = false;  ///< every second row by half a block
};

/// How far a place lies inside a rectangle with rounded corners about the origin; negative outside.
double inside(const Eigen::Array2d& place, const Eigen::Array2d& half, double corner) {
  const Eigen::Array2d off = place.abs() - half + corner;
  return corner - off.max(0.0).matrix().norm() - std::min(off.maxCoeff(), 0.0);
}

/// Height of the rounded edge of a block, this far inside it.
double edge(double inside, const Blocks& blocks) {
  if (inside <= 0) return -blocks.depth;
  if (inside >= blocks.rounding) return 0;
  const double off = blocks.rounding - inside;
  return std::max(-blocks.depth,
                  std::sqrt(blocks.rounding * blocks.rounding - off * off) - blocks.rounding);
}

SurfaceMap block_map(const PatternValues& values, const Blocks& blocks, int texels,
                     std::uint64_t seed) {
  const Eigen::Array2d pitch = blocks.size + blocks.joint;
  const PatternGrid grid(blocks.columns * pitch.x(), blocks.rows * pitch.y(), texels);
  values.check_detail("a joint", blocks.joint, grid.texel, 2);
  if (2 * blocks.rounding > blocks.size.minCoeff()) {
    values.refuse(fmt::format("a rounding of {} m is more than half a block", blocks.rounding), "");
  }
  core::RandomStream random(seed, 0, "texture.blocks");
  std::vector<double> lower;  // each block's own seat
  for (int i = 0; i < blocks.columns * blocks.rows; ++i) {
    lower.push_back(random.uniform() * 2 * blocks.unevenness);
  }
  std::vector<double> rough(std::size_t(grid.width) * std::size_t(grid.height));
  if (blocks.unevenness > 0) {
    rough = fractal_noise(grid, 2, pitch.maxCoeff(), 0, seed, "texture.unevenness");
  }
  std::vector<double> heights;
  heights.reserve(rough.size());
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      Eigen::Array2d place = grid.at(column, row).array();
      const int block_row = std::min(static_cast<int>(place.y() / pitch.y()), blocks.rows - 1);
      if (blocks.shifted && block_row % 2 == 1) place.x() += pitch.x() / 2;
      const int block_column = static_cast<int>(place.x() / pitch.x());
      const Eigen::Array2d centre = (Eigen::Array2d(block_column, block_row) + 0.5) * pitch;
      const double in = inside(place - centre, blocks.size / 2, blocks.rounding);
      double height = edge(in, blocks);
      if (height > -blocks.depth) {
        height -= lower[std::size_t(block_row * blocks.columns + block_column % blocks.columns)];
      }
      heights.push_back(height + blocks.unevenness * rough[heights.size()]);
    }
  }
  return relief_of(values.map(), grid, heights);
}

}  // namespace

SurfaceMap brick_map(const PatternValues& values, int texels, std::uint64_t seed) {
  Blocks blocks;
  blocks.size = {values.positive("length"), values.positive("height")};
  blocks.joint = values.positive("mortar");
  blocks.depth = values.positive("mortar_depth");
  blocks.rounding = values.not_negative("rounding");
  blocks.unevenness = values.not_negative("unevenness");
  blocks.columns = values.count("columns");
  blocks.rows = values.count("rows");
  blocks.shifted = true;
  if (blocks.rows % 2 != 0) {
    values.refuse(
        fmt::format("{} rows of bricks, each shifted by half a brick, do not repeat", blocks.rows),
        "an even number of rows does");
  }
  return block_map(values, blocks, texels, seed);
}

SurfaceMap tile_map(const PatternValues& values, int texels, std::uint64_t seed) {
  Blocks blocks;
  blocks.size.setConstant(values.positive("side"));
  blocks.joint = values.positive("gap");
  blocks.depth = values.positive("gap_depth");
  blocks.rounding = values.not_negative("rounding");
  blocks.unevenness = values.not_negative("unevenness");
  blocks.columns = blocks.rows = values.count("columns");
  return block_map(values, blocks, texels, seed);
}

}  // namespace carillon::render::maps
