#include "render/detail/inside_cells.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace carillon::render {

namespace {

/// A vertex seen along the line's axis.
struct Planar {
  double u = 0;
  double v = 0;
};

bool before(const Planar& a, const Planar& b) {
  return a.u < b.u || (a.u == b.u && a.v < b.v);
}

/// Side of the directed line a -> b that p lies on: 1 left, -1 right, never 0. The product is
/// formed for one order of the two ends, so that both faces of an edge get opposite answers to the
/// last bit; a point on the line counts as left of the edge that leads forward in (u, v).
int side(const Planar& a, const Planar& b, const Planar& p) {
  if (before(b, a)) return -side(b, a, p);
  const double turn = (b.u - a.u) * (p.v - a.v) - (b.v - a.v) * (p.u - a.u);
  return turn >= 0 ? 1 : -1;
}

struct Crossing {
  double height;
  int direction;
};

}  // namespace

std::vector<std::uint8_t> cells_inside(const std::vector<Vec3>& vertices,
                                       const std::vector<solvers::mesh::Triangle>& triangles,
                                       int n) {
  const auto size = static_cast<std::size_t>(n);
  std::vector<std::uint8_t> votes(size * size * size, 0);
  const std::array<std::size_t, 3> stride = {size * size, size, 1};
  const auto first_centre = [&](double low) {
    return static_cast<int>(std::clamp(std::ceil(low - 0.5), 0.0, static_cast<double>(n)));
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int across = (axis + 1) % 3;
    const int up = (axis + 2) % 3;
    std::vector<std::vector<Crossing>> columns(size * size);
    for (const solvers::mesh::Triangle& triangle : triangles) {
      std::array<Vec3, 3> corner;
      std::array<Planar, 3> flat;
      for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = vertices[static_cast<std::size_t>(triangle[k])];
        flat[k] = {corner[k][across], corner[k][up]};
      }
      const auto [u_low, u_high] = std::minmax({flat[0].u, flat[1].u, flat[2].u});
      const auto [v_low, v_high] = std::minmax({flat[0].v, flat[1].v, flat[2].v});
      for (int i = first_centre(u_low); i < n && i + 0.5 <= u_high; ++i) {
        for (int j = first_centre(v_low); j < n && j + 0.5 <= v_high; ++j) {
          const Planar p{i + 0.5, j + 0.5};
          const int turn = side(flat[0], flat[1], p);
          if (side(flat[1], flat[2], p) != turn || side(flat[2], flat[0], p) != turn) continue;
          // Height by barycentric weights; a face seen edge-on gives any of its heights.
          const auto area = [](const Planar& a, const Planar& b, const Planar& c) {
            return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
          };
          const double w0 = area(flat[1], flat[2], p);
          const double w1 = area(flat[2], flat[0], p);
          const double w2 = area(flat[0], flat[1], p);
          const double sum = w0 + w1 + w2;
          const double height =
              sum != 0 ? (w0 * corner[0][axis] + w1 * corner[1][axis] + w2 * corner[2][axis]) / sum
                       : corner[0][axis];
          columns[static_cast<std::size_t>(i) * size + static_cast<std::size_t>(j)].push_back(
              {height, turn});
        }
      }
    }
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j < size; ++j) {
        auto& column = columns[i * size + j];
        std::sort(column.begin(), column.end(),
                  [](const Crossing& a, const Crossing& b) { return a.height < b.height; });
        int winding = 0;
        std::size_t next = 0;
        for (std::size_t k = 0; k < size; ++k) {
          while (next < column.size() && column[next].height < static_cast<double>(k) + 0.5) {
            winding += column[next++].direction;
          }
          votes[i * stride[static_cast<std::size_t>(across)] +
                j * stride[static_cast<std::size_t>(up)] +
                k * stride[static_cast<std::size_t>(axis)]] += winding != 0 ? 1 : 0;
        }
      }
    }
  }
  for (std::uint8_t& vote : votes) vote = vote >= 2 ? 1 : 0;
  return votes;
}

}  // namespace carillon::render
