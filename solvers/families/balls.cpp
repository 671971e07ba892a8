#include "solvers/families/family.hpp"

namespace carillon::solvers::families {
namespace {

mesh::Meridian sphere_meridian(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  return mesh::ball_meridian(parameter(shape, "radius"));
}

mesh::ShapeExtent pebble_extent(const mesh::GeneratedShape& shape) {
  return box_extent(
      {parameter(shape, "length"), parameter(shape, "width"), parameter(shape, "height")},
      ellipsoid_fraction);
}

}  // namespace

std::vector<Family> ball_families() {
  return {{"sphere",
           "solid ball about the origin",
           {{"radius", 0.01, 0.06, "[m]"}},
           check_parameters,
           nullptr,
           sphere_meridian},
          {"pebble",
           "solid ellipsoid about the origin",
           {{"length", 0.05, 0.12, "along x [m]"},
            {"width", 0.04, 0.08, "along y [m]"},
            {"height", 0.03, 0.06, "along z [m]"}},
           check_parameters,
           nullptr,
           nullptr,
           pebble_extent}};
}

}  // namespace carillon::solvers::families
