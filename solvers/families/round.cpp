#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "solvers/families/detail/shell.hpp"
#include "solvers/families/extrude.hpp"
#include "solvers/mesh/sizing.hpp"

namespace carillon::solvers::families {
namespace {

constexpr double whole_turn = 2 * std::numbers::pi;

Shell disc(const mesh::GeneratedShape& shape) {
  const double thickness = parameter(shape, "thickness");
  Profile profile;
  profile.line({0, thickness / 2}, {parameter(shape, "radius"), thickness / 2});
  return {std::move(profile), [thickness](double) { return thickness; }, thickness, thickness};
}

mesh::MeshResult mesh_disc(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_parameters(shape);
  return mesh_shell(disc(shape), options);
}

mesh::Meridian disc_meridian(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  return shell_meridian(disc(shape));
}

/// A disc of any thickness, in layers.
Shell cylinder(const mesh::GeneratedShape& shape) {
  return disc({"disc",
               {{"radius", parameter(shape, "radius")}, {"thickness", parameter(shape, "length")}},
               {}});
}

mesh::MeshResult mesh_cylinder(const mesh::GeneratedShape& shape,
                               const mesh::MeshOptions& options) {
  check_parameters(shape);
  return mesh_shell(cylinder(shape), options);
}

mesh::Meridian cylinder_meridian(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  // A shell's joints would fall together where the wall is thicker than the radius.
  return mesh::rectangular_meridian({0, parameter(shape, "radius")},
                                    {0, parameter(shape, "length")});
}

/// Hollow cylinder about z, [0, length] along it: cells around, along and through the wall, layers
/// along the shorter of the last two.
mesh::MeshResult mesh_annulus(double inner, double outer, double length,
                              const mesh::MeshOptions& options) {
  const double wall = outer - inner;
  const bool layers_in_wall = wall <= length;
  const double thickness = std::min(wall, length), other = std::max(wall, length);
  const auto around = [&](double cell) {
    const double chord = std::min(cell, mesh::max_chord(outer, layers_in_wall ? wall : outer));
    return 4 *
           std::max(3, static_cast<int>(std::ceil(whole_turn * outer / chord / 4 * (1 - 1e-9))));
  };
  const auto count = [&](double cell) {
    return std::int64_t{6} * around(cell) * mesh::cells_along(other, cell) *
           mesh::layers_through(thickness, cell, options);
  };
  const double cell = mesh::cell_size(options, thickness, std::max(2 * outer, length), count);
  const PlanarGrid grid = rectangle_grid(around(cell), mesh::cells_along(other, cell), true);
  return finish(extrude(grid, mesh::layers_through(thickness, cell, options), options.order,
                        [=](const Vec2& p, double t) {
                          const double angle = whole_turn * p.x();
                          const double across = layers_in_wall ? t : p.y();
                          const double along = layers_in_wall ? p.y() : t;
                          const double r = (1 - across) * inner + across * outer;
                          return Vec3(r * std::cos(angle), r * std::sin(angle), along * length);
                        }));
}

/// The section of the same, with cells of their own along the ends of a thin wall.
mesh::Meridian annulus_meridian(double inner, double outer, double length) {
  const double wall = outer - inner;
  const auto radii = mesh::with_edge_layers(wall, length),
             heights = mesh::with_edge_layers(length, wall);
  mesh::Meridian out = mesh::rectangular_meridian(radii, heights);
  for (auto& block : out.blocks) {
    block.point = [inner, point = std::move(block.point)](double u, double v) -> Vec2 {
      return point(u, v) + Vec2(inner, 0);
    };
  }
  return out;
}

void check_tube(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  require(parameter(shape, "wall") < parameter(shape, "radius"), shape,
          "the wall must be thinner than the radius");
}

mesh::MeshResult mesh_tube(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_tube(shape);
  const double radius = parameter(shape, "radius");
  return mesh_annulus(radius - parameter(shape, "wall"), radius, parameter(shape, "length"),
                      options);
}

mesh::Meridian tube_meridian(const mesh::GeneratedShape& shape) {
  check_tube(shape);
  const double radius = parameter(shape, "radius");
  return annulus_meridian(radius - parameter(shape, "wall"), radius, parameter(shape, "length"));
}

void check_ring(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  require(parameter(shape, "inner_radius") < parameter(shape, "radius"), shape,
          "inner_radius must be smaller than radius");
}

mesh::MeshResult mesh_ring(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_ring(shape);
  return mesh_annulus(parameter(shape, "inner_radius"), parameter(shape, "radius"),
                      parameter(shape, "height"), options);
}

mesh::Meridian ring_meridian(const mesh::GeneratedShape& shape) {
  check_ring(shape);
  return annulus_meridian(parameter(shape, "inner_radius"), parameter(shape, "radius"),
                          parameter(shape, "height"));
}

}  // namespace

std::vector<Family> round_families() {
  return {{"disc",
           "flat round disc",
           {{"radius", 0.04, 0.15, "[m]"}, {"thickness", 0.003, 0.015, "along z [m]"}},
           check_parameters,
           mesh_disc,
           disc_meridian,
           nullptr,
           60},
          {"cylinder",
           "solid cylinder",
           {{"radius", 0.02, 0.05, "[m]"}, {"length", 0.05, 0.15, "along z [m]"}},
           check_parameters,
           mesh_cylinder,
           cylinder_meridian},
          {"tube",
           "round tube, open at both ends",
           {{"radius", 0.01, 0.04, "outer radius [m]"},
            {"wall", 0.0015, 0.005, "thickness [m]"},
            {"length", 0.08, 0.3, "along z [m]"}},
           check_tube,
           mesh_tube,
           tube_meridian,
           nullptr,
           110},
          {"ring",
           "ring with a rectangular section",
           {{"radius", 0.04, 0.09, "outer radius [m]"},
            {"inner_radius", 0.02, 0.035, "[m]"},
            {"height", 0.005, 0.02, "along z [m]"}},
           check_ring,
           mesh_ring,
           ring_meridian,
           nullptr,
           60}};
}

}  // namespace carillon::solvers::families
