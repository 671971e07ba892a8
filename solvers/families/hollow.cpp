// Closed bodies with a hollow inside. From outside they look like the solid ones: block, cylinder
// and pebble.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "solvers/families/detail/cube_grid.hpp"
#include "solvers/families/detail/twin_discs.hpp"
#include "solvers/families/family.hpp"
#include "solvers/mesh/mirrored_part.hpp"
#include "solvers/mesh/sizing.hpp"

namespace carillon::solvers::families {
namespace {

Vec3 sides_of(const mesh::GeneratedShape& shape) {
  return {parameter(shape, "length"), parameter(shape, "width"), parameter(shape, "height")};
}

void check_box(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  require(4 * parameter(shape, "wall") <= sides_of(shape).minCoeff(), shape,
          "the wall must not be thicker than a quarter of the shortest side");
}

/// Where the block of these sides lies, its walls mitred along the edges.
mesh::MeshResult mesh_hollow_box(const mesh::GeneratedShape& shape,
                                 const mesh::MeshOptions& options) {
  check_box(shape);
  const Vec3 sides = sides_of(shape);
  const double wall = parameter(shape, "wall");
  const auto cells = [&](double cell) {
    return std::array{even_cells(mesh::cells_along(sides.x(), cell)),
                      even_cells(mesh::cells_along(sides.y(), cell)),
                      even_cells(mesh::cells_along(sides.z(), cell))};
  };
  const auto count = [&](double cell) {
    return 6 * cube_cells(cells(cell)) * mesh::layers_through(wall, cell, options);
  };
  const double cell = mesh::cell_size(options, wall, sides.maxCoeff(), count);
  const Vec3 half = sides / 2;
  return finish(
      mesh::symmetrised(extrude(cube_grid(cells(cell)), mesh::layers_through(wall, cell, options),
                                options.order, [=](const Vec2& chart, double t) -> Vec3 {
                                  const Vec3 reach = half.array() - (1 - t) * wall;
                                  return on_cube(chart).cwiseProduct(reach) + Vec3(0, 0, half.z());
                                })));
}

void check_can(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  const double wall = parameter(shape, "wall");
  require(2 * wall <= parameter(shape, "radius"), shape,
          "the wall must not be thicker than half the radius");
  require(4 * wall <= parameter(shape, "length"), shape,
          "the wall must not be thicker than a quarter of the length");
}

mesh::GeneratedShape turned_can(const mesh::GeneratedShape& shape) {
  check_can(shape);
  const double r = parameter(shape, "radius"), h = parameter(shape, "length");
  const double w = parameter(shape, "wall");
  return {"turned",
          {},
          {{0, 0}, {r, 0}, {r, h}, {0, h}, {0, h - w}, {r - w, h - w}, {r - w, w}, {0, w}}};
}

/// Over the flat ends to half the height: two discs, the cells of each as on the skin.
DiscGrid plan_of_can(double radius, double height, double wall, double cell) {
  const double around =
      2 * std::numbers::pi * radius / std::min(cell, mesh::max_chord(radius, wall)) * (1 - 1e-9);
  DiscGrid disc = flat_disc(4 * std::max(3, static_cast<int>(std::ceil(around / 4))), radius, cell);
  const int rings = mesh::cells_along(height / 2, cell);
  for (int k = 1; k <= rings; ++k) disc.circles.push_back(radius + height / 2 * k / rings);
  return disc;
}

/// Mitred along its two edges.
mesh::MeshResult mesh_can(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_can(shape);
  const double radius = parameter(shape, "radius"), height = parameter(shape, "length"),
               wall = parameter(shape, "wall");
  const auto count = [&](double cell) {
    return 12 * plan_of_can(radius, height, wall, cell).cells() *
           mesh::layers_through(wall, cell, options);
  };
  const double cell = mesh::cell_size(options, wall, std::max(2 * radius, height), count);
  const DiscGrid disc = plan_of_can(radius, height, wall, cell);
  return finish(extrude(twin_discs(disc), mesh::layers_through(wall, cell, options), options.order,
                        [=](const Vec2& chart, double t) -> Vec3 {
                          const TwinPlace place = on_twin(disc, chart);
                          const double s = place.at.norm(), depth = (1 - t) * wall;
                          const Vec2 spoke = s > 0 ? Vec2(place.at / s) : Vec2(Vec2::Zero());
                          const double along_end = std::min(s / radius, 1.0);
                          const double up_side = std::max(0.0, (s - radius) / (height / 2));
                          const double r = along_end * (radius - depth);
                          const double z = depth + up_side * (height / 2 - depth);
                          return {r * spoke.x(), r * spoke.y(), place.on_second ? height - z : z};
                        }));
}

mesh::Meridian can_meridian(const mesh::GeneratedShape& shape) {
  return turned_family().meridian(turned_can(shape));
}

/// Cells of a cube's surface struck up to an ellipsoid, of nearly equal angles.
mesh::MeshResult mesh_bauble(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_box(shape);
  const Vec3 half = sides_of(shape) / 2;
  const double wall = parameter(shape, "wall");
  // Where the long axis ends the surface bends with the smallest radius.
  const double tightest = std::pow(half.minCoeff(), 2) / half.maxCoeff();
  const auto cells = [&](double cell) {
    const double longest = std::min(cell, mesh::max_chord(half.minCoeff(), wall));
    const auto along = [&](double reach) {
      const double by_bend =
          std::numbers::pi / 2 * std::sqrt(reach / tightest) / mesh::max_element_angle;
      return even_cells(std::max(mesh::cells_along(reach * std::numbers::pi / 2, longest),
                                 static_cast<int>(std::ceil(by_bend * (1 - 1e-9)))));
    };
    return std::array{along(half.x()), along(half.y()), along(half.z())};
  };
  const auto count = [&](double cell) {
    return 6 * cube_cells(cells(cell)) * mesh::layers_through(wall, cell, options);
  };
  const double cell = mesh::cell_size(options, wall, 2 * half.maxCoeff(), count);
  return finish(mesh::symmetrised(
      extrude(cube_grid(cells(cell)), mesh::layers_through(wall, cell, options), options.order,
              [=](const Vec2& chart, double t) -> Vec3 {
                const Vec3 even = (on_cube(chart).array() * (std::numbers::pi / 4)).tan();
                const Vec3 reach = half.array() - (1 - t) * wall;
                return even.normalized().cwiseProduct(reach);
              })));
}

/// @param fraction  of its box that the body fills from outside
mesh::ShapeExtent hollow_extent(const mesh::GeneratedShape& shape, double fraction) {
  const double wall = parameter(shape, "wall");
  const Vec3 sides(parameter(shape, "length"), parameter(shape, "width"),
                   parameter(shape, "height"));
  mesh::ShapeExtent extent = box_extent(sides, fraction);
  extent.volume -= fraction * (sides.array() - 2 * wall).prod();
  extent.thickness = wall;
  extent.mirror_planes = 3;
  return extent;
}

mesh::ShapeExtent box_of_walls(const mesh::GeneratedShape& shape) {
  return hollow_extent(shape, 1);
}

mesh::ShapeExtent bauble_extent(const mesh::GeneratedShape& shape) {
  return hollow_extent(shape, ellipsoid_fraction);
}

}  // namespace

std::vector<Family> hollow_families() {
  return {{"box",
           "hollow rectangular box, closed all around: a block from outside",
           {{"length", 0.05, 0.15, "along x [m]"},
            {"width", 0.04, 0.1, "along y [m]"},
            {"height", 0.03, 0.08, "along z [m]"},
            {"wall", 0.0015, 0.005, "thickness [m]"}},
           check_box,
           mesh_hollow_box,
           nullptr,
           box_of_walls},
          {"can",
           "hollow cylinder, closed at both ends: a cylinder from outside",
           {{"radius", 0.02, 0.05, "[m]"},
            {"length", 0.05, 0.15, "along z [m]"},
            {"wall", 0.0015, 0.005, "thickness [m]"}},
           check_can,
           mesh_can,
           can_meridian},
          {"bauble",
           "hollow ellipsoid about the origin: a pebble from outside",
           {{"length", 0.05, 0.12, "along x [m]"},
            {"width", 0.04, 0.08, "along y [m]"},
            {"height", 0.03, 0.06, "along z [m]"},
            {"wall", 0.0015, 0.005, "thickness at the ends of the axes [m]"}},
           check_box,
           mesh_bauble,
           nullptr,
           bauble_extent}};
}

}  // namespace carillon::solvers::families
