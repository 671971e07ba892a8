#include "solvers/families/detail/cube_grid.hpp"

#include <map>

namespace carillon::solvers::families {
namespace {

/// Axis of a face, and those that its u and v run along: outward where u, v, outward are
/// right-handed.
struct CubeFace {
  std::size_t across, u, v;
  bool positive;
};

/// Faces -x, +x, -y, +y, -z, +z.
CubeFace face_of(int number) {
  const auto axis = static_cast<std::size_t>(number / 2);
  const std::size_t next = (axis + 1) % 3, last = (axis + 2) % 3;
  return number % 2 == 1 ? CubeFace{axis, next, last, true} : CubeFace{axis, last, next, false};
}

/// Faces lie beside each other along x, with a gap, so that a point of an edge has a face.
constexpr double pitch = 2;

}  // namespace

Vec3 on_cube(const Vec2& chart) {
  const int number = static_cast<int>((chart.x() + 0.5) / pitch);
  const CubeFace face = face_of(number);
  std::array<double, 3> at{};
  at[face.across] = face.positive ? 1 : -1;
  at[face.u] = 2 * (chart.x() - pitch * number) - 1;
  at[face.v] = 2 * chart.y() - 1;
  return {at[0], at[1], at[2]};
}

std::int64_t cube_cells(const std::array<int, 3>& cells) {
  const auto [x, y, z] = cells;
  return 2 * (std::int64_t{x} * y + std::int64_t{y} * z + std::int64_t{z} * x);
}

PlanarGrid cube_grid(const std::array<int, 3>& cells) {
  PlanarGrid grid;
  std::map<std::array<int, 3>, std::int32_t> known;
  std::vector<std::array<Vec2, 3>> corners;
  for (int number = 0; number < 6; ++number) {
    const CubeFace face = face_of(number);
    const int across = cells[face.across], nu = cells[face.u], nv = cells[face.v];
    const auto vertex = [&](int i, int j) {
      std::array<int, 3> at{};
      at[face.across] = face.positive ? across : 0;
      at[face.u] = i;
      at[face.v] = j;
      return known.try_emplace(at, static_cast<std::int32_t>(known.size())).first->second;
    };
    const auto chart = [&](int i, int j) {
      return Vec2(pitch * number + static_cast<double>(i) / nu, static_cast<double>(j) / nv);
    };
    const auto add = [&](const std::array<std::array<int, 2>, 3>& c) {
      grid.triangles.push_back(
          {vertex(c[0][0], c[0][1]), vertex(c[1][0], c[1][1]), vertex(c[2][0], c[2][1])});
      corners.push_back(
          {chart(c[0][0], c[0][1]), chart(c[1][0], c[1][1]), chart(c[2][0], c[2][1])});
    };
    for (int j = 0; j < nv; ++j)
      for (int i = 0; i < nu; ++i) {
        // Diagonals towards the face's middle, so that every corner of the cube is halved alike.
        if ((2 * i + 1 - nu) * (2 * j + 1 - nv) >= 0) {
          add({{{i, j}, {i + 1, j}, {i + 1, j + 1}}});
          add({{{i, j}, {i + 1, j + 1}, {i, j + 1}}});
        } else {
          add({{{i, j}, {i + 1, j}, {i, j + 1}}});
          add({{{i + 1, j}, {i + 1, j + 1}, {i, j + 1}}});
        }
      }
  }
  grid.vertices = static_cast<std::int32_t>(known.size());
  grid.point = [corners](std::size_t t, const Eigen::Vector3d& b) -> Vec2 {
    return b[0] * corners[t][0] + b[1] * corners[t][1] + b[2] * corners[t][2];
  };
  return grid;
}

}  // namespace carillon::solvers::families
