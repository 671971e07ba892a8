#include <algorithm>
#include <array>

#include "solvers/families/extrude.hpp"
#include "solvers/families/family.hpp"
#include "solvers/mesh/mirrored_part.hpp"
#include "solvers/mesh/sizing.hpp"

namespace carillon::solvers::families {
namespace {

/// Box [-x/2, x/2] x [-y/2, y/2] x [0, z], layers along its shortest side.
mesh::MeshResult mesh_box(const Vec3& sides, const mesh::MeshOptions& options) {
  std::array<Eigen::Index, 3> axis{0, 1, 2};
  std::stable_sort(axis.begin(), axis.end(),
                   [&](Eigen::Index i, Eigen::Index j) { return sides[i] > sides[j]; });
  const double along = sides[axis[0]], across = sides[axis[1]], thickness = sides[axis[2]];
  const auto cells = [&](double cell) {
    return std::array{even_cells(mesh::cells_along(along, cell)),
                      even_cells(mesh::cells_along(across, cell)),
                      even_cells(mesh::layers_through(thickness, cell, options))};
  };
  const auto count = [&](double cell) {
    const auto [nx, ny, layers] = cells(cell);
    return std::int64_t{6} * nx * ny * layers;
  };
  const auto [nx, ny, layers] = cells(mesh::cell_size(options, thickness, along, count));
  const Vec3 shift(0.5 * sides.x(), 0.5 * sides.y(), 0);
  return finish(mesh::symmetrised(
      extrude(rectangle_grid(nx, ny, false), layers, options.order, [=](const Vec2& p, double t) {
        Vec3 at;
        at[axis[0]] = p.x() * along;
        at[axis[1]] = p.y() * across;
        at[axis[2]] = t * thickness;
        return Vec3(at - shift);
      })));
}

mesh::MeshResult mesh_bar(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_parameters(shape);
  return mesh_box(
      {parameter(shape, "length"), parameter(shape, "width"), parameter(shape, "height")}, options);
}

void check_tile(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  require(parameter(shape, "thickness") <=
              std::min(parameter(shape, "length"), parameter(shape, "width")),
          shape, "thickness must not exceed length or width");
}

mesh::MeshResult mesh_tile(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_tile(shape);
  return mesh_box(
      {parameter(shape, "length"), parameter(shape, "width"), parameter(shape, "thickness")},
      options);
}

mesh::ShapeExtent mirrored_extent(const Vec3& sides) {
  mesh::ShapeExtent extent = box_extent(sides);
  extent.mirror_planes = 2;
  extent.is_halved = true;
  return extent;
}

mesh::ShapeExtent bar_extent(const mesh::GeneratedShape& shape) {
  return mirrored_extent(
      {parameter(shape, "length"), parameter(shape, "width"), parameter(shape, "height")});
}

mesh::ShapeExtent tile_extent(const mesh::GeneratedShape& shape) {
  return mirrored_extent(
      {parameter(shape, "length"), parameter(shape, "width"), parameter(shape, "thickness")});
}

}  // namespace

std::vector<Family> box_families() {
  return {{"bar",
           "straight bar with a rectangular section, such as a chime or a xylophone's",
           {{"length", 0.12, 0.4, "along x [m]"},
            {"width", 0.015, 0.04, "along y [m]"},
            {"height", 0.004, 0.015, "along z [m]"}},
           check_parameters,
           mesh_bar,
           nullptr,
           bar_extent},
          {"block",
           "solid rectangular block",
           {{"length", 0.05, 0.15, "along x [m]"},
            {"width", 0.04, 0.1, "along y [m]"},
            {"height", 0.03, 0.08, "along z [m]"}},
           check_parameters,
           mesh_bar,
           nullptr,
           bar_extent},
          {"tile",
           "thin rectangular tile or pane",
           {{"length", 0.08, 0.25, "along x [m]"},
            {"width", 0.08, 0.25, "along y [m]"},
            {"thickness", 0.004, 0.012, "along z [m]"}},
           check_tile,
           mesh_tile,
           nullptr,
           tile_extent}};
}

}  // namespace carillon::solvers::families
