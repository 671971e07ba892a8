#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/families/extrude.hpp"
#include "solvers/mesh/sizing.hpp"

namespace carillon::solvers::families {
namespace {

/// A corner of a cell: its vertex and its coordinates in the cell's own chart.
struct ChartPoint {
  std::int32_t vertex;
  Vec2 at;
};

enum class Chart { core, transition, circles };

/// A grid whose triangles are straight in a chart and curved by the chart's formula.
struct ChartTriangles {
  std::vector<std::array<Vec2, 3>> corners;
  std::vector<Chart> charts;

  void add_cell(PlanarGrid& grid, Chart chart, const std::array<ChartPoint, 4>& cell,
                bool first_diagonal = true) {
    // Cell corners go around; the first diagonal joins corners 0 and 2.
    const std::array<std::array<std::size_t, 3>, 2> cut =
        first_diagonal ? std::array<std::array<std::size_t, 3>, 2>{{{0, 1, 2}, {0, 2, 3}}}
                       : std::array<std::array<std::size_t, 3>, 2>{{{0, 1, 3}, {1, 2, 3}}};
    for (const auto& [a, b, c] : cut) {
      grid.triangles.push_back({cell[a].vertex, cell[b].vertex, cell[c].vertex});
      corners.push_back({cell[a].at, cell[b].at, cell[c].at});
      charts.push_back(chart);
    }
  }
  Vec2 at(std::size_t triangle, const Eigen::Vector3d& b) const {
    const auto& c = corners[triangle];
    return b[0] * c[0] + b[1] * c[1] + b[2] * c[2];
  }
};

/// How far the sides of a disc's middle square bulge: its corners open to 117 degrees, so that
/// they and the two cells outside share the full turn about evenly.
constexpr double bulge = 0.12;

/// Point of the middle square, (u, v) in [-1, 1]^2, with corners at radius 1.
Vec2 square_point(double u, double v) {
  const double a = std::numbers::sqrt2 / 2;
  return {a * u * (1 + bulge * (1 - v * v)), a * v * (1 + bulge * (1 - u * u))};
}

/// Point of the square's outline: `turn` in quarter turns from the corner at -45 degrees.
Vec2 outline_point(double turn) {
  const int side = std::min(3, static_cast<int>(turn));
  Vec2 p = square_point(1, 2 * (turn - side) - 1);
  for (int i = 0; i < side; ++i) p = Vec2(-p.y(), p.x());
  return p;
}

Vec2 circle_point(double turn) {
  // By quarter turns, so that the four-fold symmetry is exact.
  const int side = std::min(3, static_cast<int>(turn));
  const double angle = (turn - side - 0.5) * std::numbers::pi / 2;
  Vec2 p(std::cos(angle), std::sin(angle));
  for (int i = 0; i < side; ++i) p = Vec2(-p.y(), p.x());
  return p;
}

}  // namespace

PlanarGrid rectangle_grid(int nx, int ny, bool periodic) {
  PlanarGrid grid;
  ChartTriangles cells;
  const int columns = periodic ? nx : nx + 1;
  grid.vertices = columns * (ny + 1);
  const auto corner = [&](int i, int j) {
    return ChartPoint{j * columns + i % columns,
                      {static_cast<double>(i) / nx, static_cast<double>(j) / ny}};
  };
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i)
      cells.add_cell(grid, Chart::core,
                     {corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)});
  grid.point = [cells](std::size_t t, const Eigen::Vector3d& b) { return cells.at(t, b); };
  return grid;
}

std::int64_t DiscGrid::cells() const {
  const std::int64_t side = around / 4;
  return side * side + around * (transition + static_cast<std::int64_t>(circles.size()) - 1);
}

DiscGrid flat_disc(int around, double radius, double cell) {
  DiscGrid disc;
  disc.around = around;
  // The square takes about half of the disc; rings of cells as wide as its own lead from it to a
  // circle. The square's sides lie a fifth of its radius further in than its corners.
  const int side = around / 4;
  disc.core = 0.6 * radius;
  disc.transition = std::max(1, static_cast<int>(std::lround(side / 7.0)));
  double first = disc.core * std::min(1.6, 1 + 1.5 * disc.transition / side);
  const double local = 2 * std::numbers::pi * radius / around;
  if (radius - first < 0.5 * std::min(cell, local)) first = radius;
  disc.circles.push_back(first);
  const int rings = first < radius ? mesh::cells_along(radius - first, cell) : 0;
  for (int k = 1; k <= rings; ++k) {
    disc.circles.push_back(k == rings ? radius : first + (radius - first) * k / rings);
  }
  return disc;
}

PlanarGrid disc_grid(const DiscGrid& disc) {
  const int side = disc.around / 4;
  PlanarGrid grid;
  ChartTriangles cells;

  const auto in_square = [&](int i, int j) {
    return ChartPoint{j * (side + 1) + i, {2.0 * i / side - 1, 2.0 * j / side - 1}};
  };
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      // Diagonals point away from the centre, so that one halves each wide corner.
      const bool first = (2 * i + 1 - side) * (2 * j + 1 - side) >= 0;
      cells.add_cell(
          grid, Chart::core,
          {in_square(i, j), in_square(i + 1, j), in_square(i + 1, j + 1), in_square(i, j + 1)},
          first);
    }

  const auto on_outline = [&](int i) -> std::int32_t {
    i %= disc.around;
    const int k = i % side;
    switch (i / side) {
      case 0:
        return k * (side + 1) + side;
      case 1:
        return side * (side + 1) + side - k;
      case 2:
        return (side - k) * (side + 1);
      default:
        return k;
    }
  };
  // Ring 0 is the square's outline; rings 1 to transition lead to the first circle.
  const int rings = disc.transition + static_cast<int>(disc.circles.size()) - 1;
  const std::int32_t first_ring = (side + 1) * (side + 1);
  grid.vertices = first_ring + rings * disc.around;
  const auto vertex = [&](int i, int ring) {
    return ring == 0 ? on_outline(i) : first_ring + (ring - 1) * disc.around + i % disc.around;
  };
  for (int ring = 0; ring < rings; ++ring) {
    const bool inner = ring < disc.transition;
    const auto across = [&](int r) {
      return inner ? static_cast<double>(r) / disc.transition
                   : disc.circles[static_cast<std::size_t>(r - disc.transition)];
    };
    for (int i = 0; i < disc.around; ++i) {
      const auto corner = [&](int k, int r) {
        return ChartPoint{vertex(k, r), {static_cast<double>(k) / side, across(r)}};
      };
      cells.add_cell(
          grid, inner ? Chart::transition : Chart::circles,
          {corner(i, ring), corner(i, ring + 1), corner(i + 1, ring + 1), corner(i + 1, ring)});
    }
  }
  const double core = disc.core, circle = disc.circles.front();
  grid.point = [cells, core, circle](std::size_t t, const Eigen::Vector3d& b) -> Vec2 {
    const Vec2 at = cells.at(t, b);
    switch (cells.charts[t]) {
      case Chart::core:
        return core * square_point(at.x(), at.y());
      case Chart::transition:
        return (1 - at.y()) * core * outline_point(at.x()) + at.y() * circle * circle_point(at.x());
      default:
        return at.y() * circle_point(at.x());
    }
  };
  return grid;
}

}  // namespace carillon::solvers::families
