#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/random.hpp"
#include "render/maps/detail/patterns.hpp"

namespace carillon::render::maps {
namespace {

struct Pebble {
  Eigen::Vector2d centre;  ///< within the first repetition, or just beyond [m]
  double sunk = 0;         ///< as part of the depth
};

/// Pebbles near the corners of a lattice of triangles that repeats.
struct Bed {
  int columns, rows;  ///< rows: even
  Eigen::Array2d pitch;
  std::vector<Pebble> pebbles;

  Bed(double size, int columns_, double irregularity, std::uint64_t seed)
      : columns(columns_),
        rows(2 * std::max(1, static_cast<int>(std::lround(columns_ / std::sqrt(3.0))))),
        pitch(size, size * columns_ / rows) {
    core::RandomStream random(seed, 0, "texture.pebbles");
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        const Eigen::Array2d lattice(column + (row % 2 == 0 ? 0.25 : 0.75), row + 0.5);
        const double off_u = random.uniform(-0.4, 0.4), off_v = random.uniform(-0.4, 0.4);
        const Eigen::Array2d centre =
            (lattice + irregularity * Eigen::Array2d(off_u, off_v)) * pitch;
        pebbles.push_back({centre.matrix(), 0.3 * irregularity * random.uniform()});
      }
    }
  }

  /// A pebble by column and row, which may lie in a repetition.
  Pebble at(int column, int row) const {
    const auto wrap = [](int i, int n) { return (i % n + n) % n; };
    Pebble pebble = pebbles[std::size_t(wrap(row, rows) * columns + wrap(column, columns))];
    pebble.centre += Eigen::Vector2d((column - wrap(column, columns)) * pitch.x(),
                                     (row - wrap(row, rows)) * pitch.y());
    return pebble;
  }
};

/// Height of a place between 0 (the middle of a pebble) and -1.
double height_in(const Bed& bed, const Eigen::Vector2d& place) {
  constexpr int around = 2;
  constexpr int count = (2 * around + 1) * (2 * around + 1);
  std::array<Pebble, count> near;
  const int column = static_cast<int>(place.x() / bed.pitch.x());
  const int row = static_cast<int>(place.y() / bed.pitch.y());
  std::size_t own = 0, next = 0;
  for (int j = -around; j <= around; ++j) {
    for (int i = -around; i <= around; ++i, ++next) {
      near[next] = bed.at(column + i, row + j);
      if ((near[next].centre - place).squaredNorm() < (near[own].centre - place).squaredNorm()) {
        own = next;
      }
    }
  }
  // How near the bisectors with its neighbours, 1 on them; the sum of powers rounds the corners.
  const Eigen::Vector2d off = place - near[own].centre;
  double sum = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (k == own) continue;
    const Eigen::Vector2d way = near[k].centre - near[own].centre;
    const double part = std::max(0.0, 2 * off.dot(way) / way.squaredNorm());
    const double square = part * part;
    sum += square * square * square;
  }
  const double radius2 = std::cbrt(sum);
  if (radius2 >= 1) return -1;
  const double sunk = near[own].sunk;
  return (1 - sunk) * std::sqrt(1 - radius2) - 1;
}

}  // namespace

SurfaceMap pebble_map(const PatternValues& values, int texels, std::uint64_t seed) {
  const double size = values.positive("size");
  const double depth = values.positive("depth");
  const double irregularity = values.not_negative("irregularity");
  const int columns = values.count("columns");
  if (irregularity > 1) {
    values.refuse(fmt::format("irregularity is {}", irregularity), "0 to 1");
  }
  if (columns < 3) values.refuse(fmt::format("{} columns of pebbles", columns), "at least 3");
  const PatternGrid grid(columns * size, columns * size, texels);
  values.check_detail("a pebble", size, grid.texel, 6);
  const Bed bed(size, columns, irregularity, seed);
  std::vector<double> heights;
  heights.reserve(std::size_t(grid.width) * std::size_t(grid.height));
  for (int row = 0; row < grid.height; ++row) {
    for (int column = 0; column < grid.width; ++column) {
      heights.push_back(depth * height_in(bed, grid.at(column, row)));
    }
  }
  return relief_of(values.map(), grid, heights);
}

}  // namespace carillon::render::maps
