#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/families/extrude.hpp"
#include "solvers/families/family.hpp"
#include "solvers/mesh/sizing.hpp"

namespace carillon::solvers::families {
namespace {

void check_torus(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  require(parameter(shape, "tube_radius") < parameter(shape, "ring_radius"), shape,
          "tube_radius must be smaller than ring_radius, or nothing is left of the hole");
}

/// Four squares in the middle of the tube, and around them eight blocks that blend their sides to
/// the circle.
mesh::Meridian torus_meridian(const mesh::GeneratedShape& shape) {
  check_torus(shape);
  const double ring = parameter(shape, "ring_radius"), tube = parameter(shape, "tube_radius");
  constexpr double eighth = std::numbers::pi / 4;
  const auto polar = [=](double radius, double angle) -> Vec2 {
    return {ring + radius * std::cos(angle), radius * std::sin(angle)};
  };
  // Around the squares: the middle of a side, the corner after it, and so on.
  const auto inner = [=](int k) {
    return polar(0.5 * tube * (k % 2 == 0 ? 1 : std::numbers::sqrt2), k * eighth);
  };
  mesh::Meridian out;
  constexpr int centre = 16;
  for (int k = 1; k < 8; k += 2) {
    const int next = (k + 1) % 8;
    out.blocks.push_back({{centre, k - 1, k, next}, [=](double u, double v) -> Vec2 {
                            return (1 - v) * ((1 - u) * Vec2(ring, 0) + u * inner(k - 1)) +
                                   v * ((1 - u) * inner(next) + u * inner(k));
                          }});
  }
  for (int k = 0; k < 8; ++k) {
    const int next = (k + 1) % 8;
    out.blocks.push_back({{k, k + 8, next + 8, next}, [=](double u, double v) -> Vec2 {
                            return (1 - u) * ((1 - v) * inner(k) + v * inner(next)) +
                                   u * polar(tube, (k + v) * eighth);
                          }});
  }
  return out;
}

/// Its disc swept all around.
mesh::MeshResult mesh_torus(const mesh::GeneratedShape& shape, const mesh::MeshOptions& options) {
  check_torus(shape);
  constexpr double turn = 2 * std::numbers::pi;
  const double ring = parameter(shape, "ring_radius"), tube = parameter(shape, "tube_radius");
  const auto section = [tube](double cell) {
    return flat_disc(4 * std::max(2, mesh::cells_along(turn * tube / 4, cell)), tube, cell);
  };
  const auto layers = [=](double cell) {
    const double chord = std::min(cell, mesh::max_chord(ring + tube, 2 * tube));
    return mesh::cells_along(turn * (ring + tube), chord);
  };
  const auto count = [&](double cell) { return 6 * section(cell).cells() * layers(cell); };
  const double cell = mesh::cell_size(options, 2 * tube, 2 * (ring + tube), count);
  return finish(extrude(
      disc_grid(section(cell)), layers(cell), options.order,
      [=](const Vec2& p, double t) {
        const double radius = ring + p.x();
        return Vec3(radius * std::cos(turn * t), radius * std::sin(turn * t), p.y());
      },
      true));
}

}  // namespace

Family torus_family() {
  return {"torus",
          "ring with a round section, about the origin",
          {{"ring_radius", 0.03, 0.08, "from the axis to the middle of the tube [m]"},
           {"tube_radius", 0.004, 0.012, "of the section [m]"}},
          check_torus,
          mesh_torus,
          torus_meridian,
          nullptr,
          144};
}

}  // namespace carillon::solvers::families
